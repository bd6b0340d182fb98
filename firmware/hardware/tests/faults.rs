//! Each error that the check is for, put back into the design: the check names its rule.

use board_design::Design;
use board_design::check::{Rule, check};

/// What the check finds after a change of the design: the rule that must be broken, with a text.
fn found(change: impl FnOnce(&mut Design), rule: Rule, text: &str) {
    let mut design = Design::read().expect("valid files");
    change(&mut design);
    let findings = check(&design);
    let is_named = findings
        .iter()
        .any(|finding| finding.rule == rule && finding.text.contains(text));
    assert!(
        is_named,
        "{rule:?} with {text:?} is not among {findings:#?}"
    );
}

fn set_kind(design: &mut Design, designator: &str, kind: &str) {
    design.part_mut(designator).expect("a part").kind = kind.to_owned();
}

fn set_value(design: &mut Design, designator: &str, value: f64) {
    design.part_mut(designator).expect("a part").value = Some(value);
}

/// Takes pins, as `U5.8`, off their nets.
fn disconnect(design: &mut Design, pins: &[&str]) {
    for net in &mut design.nets {
        net.pins
            .retain(|(part, pin)| !pins.contains(&format!("{part}.{pin}").as_str()));
    }
}

fn connect(design: &mut Design, net: &str, part: &str, pin: &str) {
    let board = design.part(part).expect("a part").board.clone();
    let net = design
        .nets
        .iter_mut()
        .find(|other| other.board == board && other.name == net);
    net.expect("a net")
        .pins
        .push((part.to_owned(), pin.to_owned()));
}

fn remove(design: &mut Design, designator: &str) {
    design.parts.retain(|part| part.designator != designator);
    for net in &mut design.nets {
        net.pins.retain(|(part, _)| part != designator);
    }
}

/// A change of the design, the rule that it breaks, and what the finding says.
type Case = (fn(&mut Design), Rule, &'static str);

fn set_limit_max(design: &mut Design, name: &str, max: i64) {
    let mut limits = design.limits.iter_mut();
    let limit = limits.find(|limit| limit.name == name);
    limit.expect("a limit").max = max;
}

/// The row of a function of the processor.
fn pin(design: &Design, name: &str) -> usize {
    let mut pins = design.processor.iter();
    pins.position(|pin| pin.name == name).expect("a pin")
}

const CASES: [Case; 42] = [
    (
        |d| set_kind(d, "U4", "TLV7011"),
        Rule::Outputs,
        "U4 (TLV7011) drives it high",
    ),
    (
        |d| remove(d, "R14"),
        Rule::Outputs,
        "no resistor to a supply at an open-drain output",
    ),
    (
        |d| set_value(d, "R14", 47e3),
        Rule::Outputs,
        "BREAK_N rises to",
    ),
    (
        |d| {
            disconnect(d, &["U1.5"]);
            connect(d, "GA_PD", "U1", "5");
        },
        Rule::Outputs,
        "net GA_PD: outputs drive against each other",
    ),
    // 1 V/A: +1.45 A.
    (
        |d| set_value(d, "R10", 0.02),
        Rule::Ranges,
        "the default of over_current_ma is 2000 mA",
    ),
    (
        |d| set_limit_max(d, "stall_current_ma", 3000),
        Rule::Ranges,
        "the largest value of stall_current_ma is 3000 mA",
    ),
    (
        |d| disconnect(d, &["U5.8"]),
        Rule::Straps,
        "U5.8 (RS) must be tied to GND",
    ),
    (
        |d| disconnect(d, &["U10.8"]),
        Rule::Straps,
        "U10.8 (RS) must be tied to GND",
    ),
    (
        |d| set_kind(d, "U1", "TC4428A"),
        Rule::Supplies,
        "U1.6 (VDD): VM has 3.82 to 7.95 V",
    ),
    (
        |d| set_limit(d, "under_voltage_mv", 3000),
        Rule::Supplies,
        "U2.6 (VCC)",
    ),
    (
        |d| disconnect(d, &["A1.CN11-6"]),
        Rule::Connections,
        "A1.CN11-6 (E5V) is not connected",
    ),
    (
        |d| {
            disconnect(d, &["A1.CN11-6"]);
            connect(d, "VM", "A1", "CN11-6");
        },
        Rule::Supplies,
        "A1.CN11-6 (E5V): VM has",
    ),
    (|d| remove(d, "C4"), Rule::Decoupling, "U1 has no capacitor"),
    (|d| remove(d, "C8"), Rule::Decoupling, "U3 has no capacitor"),
    (|d| remove(d, "C9"), Rule::Decoupling, "U4 has no capacitor"),
    (
        |d| remove(d, "C15"),
        Rule::Decoupling,
        "U5 has no capacitor",
    ),
    (
        |d| remove(d, "C16"),
        Rule::Decoupling,
        "U6 has no capacitor",
    ),
    (
        |d| remove(d, "C20"),
        Rule::Decoupling,
        "U7 has no capacitor",
    ),
    (
        |d| remove(d, "D3"),
        Rule::Clamps,
        "LEG_A: MA reaches -1.0 V",
    ),
    (
        |d| remove(d, "D4"),
        Rule::Clamps,
        "LEG_B: MB reaches -1.0 V",
    ),
    (|d| remove(d, "D6"), Rule::Clamps, "SERVO: SERVO_IN"),
    (
        |d| remove(d, "P11"),
        Rule::Headers,
        "actuator: 1 of 2 parts of type header-70",
    ),
    (
        |d| remove(d, "J12"),
        Rule::Headers,
        "actuator: 1 of 2 parts of type socket-70",
    ),
    (
        |d| {
            disconnect(d, &["A1.CN12-52"]);
            connect(d, "AH", "A1", "CN10-4");
        },
        Rule::Connections,
        "A1 has no pin CN10-4: a pin of the Zio connectors; PE9 is CN12-52",
    ),
    (
        |d| {
            let leg = pin(d, "LEG_B");
            d.processor[leg].pin = "PC0".to_owned();
            d.processor[leg].peripheral = "ADC1_IN10".to_owned();
        },
        Rule::Processor,
        "PC0 (ADC1_IN10, LEG_B) is used twice: leg A, leg B",
    ),
    (
        |d| {
            let trip = pin(d, "BREAK");
            d.processor[trip].alternate = Some(3);
        },
        Rule::Processor,
        "PE15 has no function TIM1_BKIN:3",
    ),
    (
        |d| set_kind(d, "A11", "ST-LINK"),
        Rule::Serial,
        "ST-LINK is at the serial line",
    ),
    (
        |d| connect(d, "GND", "U3", "8"),
        Rule::Connections,
        "U3.8 is on 2 nets",
    ),
    // The clamp of 9 V reaches 14.4 V; the transistors withstand 12 V.
    (
        |d| set_kind(d, "D1", "SMAJ9.0A"),
        Rule::Gates,
        "Q1 withstands 12 V at its gate",
    ),
    (
        |d| set_value(d, "R11", 47e3),
        Rule::Trip,
        "the comparator may trip at",
    ),
    (
        |d| set_value(d, "R11", 20e3),
        Rule::Trip,
        "the amplifier reads to",
    ),
    (|d| remove(d, "R4"), Rule::Gates, "leg B, high side (PE11)"),
    (
        |d| {
            for part in ["R19", "R21", "R27", "R28"] {
                set_value(d, part, 30e3);
            }
        },
        Rule::Ranges,
        "the lower leg is at",
    ),
    (
        |d| set_value(d, "R15", 5.1e3),
        Rule::Ranges,
        "LEG_A reaches",
    ),
    (
        |d| set_value(d, "R23", 12e3),
        Rule::Ranges,
        "V_SENSE reads at most",
    ),
    (
        |d| remove(d, "R34"),
        Rule::Outputs,
        "net SERVO_BUS: no resistor to a supply at an open-drain output",
    ),
    (
        |d| set_value(d, "R34", 1e3),
        Rule::ServoBus,
        "the bus rises in 207 ns; half a bit is 167 ns",
    ),
    (
        |d| set_value(d, "R34", 390.0),
        Rule::ServoBus,
        "the pin sinks 8.8 mA",
    ),
    (
        |d| set_value(d, "R33", 150.0),
        Rule::ServoBus,
        "a servo that drives low leaves 1.09 V at the pin",
    ),
    (
        |d| set_figure(d, "STM32F429ZI", "tolerant_absolute", 3.6),
        Rule::ServoBus,
        "the bus reaches 5.5 V; the pin tolerates 3.6 V",
    ),
    (
        |d| {
            let bus = pin(d, "SERVO_BUS");
            d.processor[bus].mode = "alternate".to_owned();
        },
        Rule::ServoBus,
        "SERVO_BUS: mode, speed and pull",
    ),
    (
        |d| {
            let bus = pin(d, "SERVO_BUS");
            d.processor[bus].pull = "up".to_owned();
        },
        Rule::ServoBus,
        "SERVO_BUS: mode, speed and pull",
    ),
];

#[test]
fn each_error_breaks_its_rule_with_a_finding_that_names_it() {
    for (change, rule, text) in CASES {
        found(change, rule, text);
    }
}

fn set_figure(design: &mut Design, of: &str, figure: &str, value: f64) {
    let mut figures = design.figures.iter_mut();
    let row = figures.find(|row| row.of == of && row.figure == figure);
    row.expect("a figure").value = value;
}

fn set_limit(design: &mut Design, name: &str, default: i64) {
    let mut limits = design.limits.iter_mut();
    limits
        .find(|limit| limit.name == name)
        .expect("a limit")
        .default = default;
}

#[test]
fn the_changes_for_two_lipo_cells_make_a_sound_design() {
    let mut design = Design::read().expect("valid files");
    set_figure(&mut design, "battery", "lowest", 6.0);
    set_figure(&mut design, "battery", "highest", 8.4);
    // A duty of 86 % leaves the motor 7.25 V, and a back-EMF of 95 % of that.
    set_figure(
        &mut design,
        "motor",
        "reversal_current",
        (8.4 + 0.95 * 7.25) / 7.7,
    );
    assert!(
        !check(&design).is_empty(),
        "the design is for another supply"
    );
    for (designator, kind) in [
        ("D1", "SMAJ8.5A"),
        ("Q1", "IRF7319"),
        ("Q2", "IRF7319"),
        ("Q5", "AO3407A"),
    ] {
        set_kind(&mut design, designator, kind);
    }
    for designator in ["R11", "R15", "R17"] {
        set_value(&mut design, designator, 24.9e3);
    }
    for (limit, default) in [
        ("over_voltage_mv", 8_800),
        ("under_voltage_mv", 5_500),
        ("over_current_ma", 2_200),
    ] {
        set_limit(&mut design, limit, default);
    }
    assert_eq!(check(&design), []);
}
