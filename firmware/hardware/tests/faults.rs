//! Each error that the check is for, put back into the design: the check names it.

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

#[test]
fn a_comparator_with_a_push_pull_output() {
    found(
        |d| set_kind(d, "U4", "TLV7011"),
        Rule::Outputs,
        "U4 (TLV7011) drives it high",
    );
}

#[test]
fn an_open_drain_without_a_resistor() {
    found(
        |d| remove(d, "R14"),
        Rule::Outputs,
        "no resistor to a supply at an open-drain output",
    );
}

#[test]
fn a_resistor_too_weak_against_the_pull_down_of_the_processor() {
    found(
        |d| set_value(d, "R14", 47e3),
        Rule::Outputs,
        "BREAK_N rises to",
    );
}

#[test]
fn two_outputs_on_one_net() {
    found(
        |d| {
            disconnect(d, &["U1.5"]);
            connect(d, "GA_PD", "U1", "5");
        },
        Rule::Outputs,
        "net GA_PD: outputs drive against each other",
    );
}

#[test]
fn an_amplifier_that_saturates_below_the_over_current_limit() {
    // 1 V/A: +1.45 A.
    found(
        |d| set_value(d, "R10", 0.02),
        Rule::Ranges,
        "the default of over_current_ma is 2000 mA",
    );
}

#[test]
fn a_limit_that_can_be_set_above_what_the_amplifier_reads() {
    let change = |d: &mut Design| {
        let limit = d
            .limits
            .iter_mut()
            .find(|limit| limit.name == "stall_current_ma");
        limit.expect("a limit").max = 3000;
    };
    found(
        change,
        Rule::Ranges,
        "the largest value of stall_current_ma is 3000 mA",
    );
}

#[test]
fn a_transceiver_without_its_mode_input_at_ground() {
    found(
        |d| disconnect(d, &["U5.8"]),
        Rule::Straps,
        "U5.8 (RS) must be tied to GND",
    );
    found(
        |d| disconnect(d, &["U10.8"]),
        Rule::Straps,
        "U10.8 (RS) must be tied to GND",
    );
}

#[test]
fn a_gate_driver_that_needs_more_than_the_under_voltage_limit() {
    found(
        |d| set_kind(d, "U1", "TC4428A"),
        Rule::Supplies,
        "U1.6 (VDD): VM has 3.82 to 7.95 V",
    );
}

#[test]
fn an_under_voltage_limit_below_what_the_gate_driver_needs() {
    let change = |d: &mut Design| {
        let limit = d
            .limits
            .iter_mut()
            .find(|limit| limit.name == "under_voltage_mv");
        limit.expect("a limit").default = 3000;
    };
    found(change, Rule::Supplies, "U2.6 (VCC)");
}

#[test]
fn a_processor_board_without_a_supply() {
    found(
        |d| disconnect(d, &["A1.CN11-6"]),
        Rule::Connections,
        "A1.CN11-6 (E5V) is not connected",
    );
}

#[test]
fn a_processor_board_at_the_battery() {
    found(
        |d| {
            disconnect(d, &["A1.CN11-6"]);
            connect(d, "VM", "A1", "CN11-6");
        },
        Rule::Supplies,
        "A1.CN11-6 (E5V): VM has",
    );
}

#[test]
fn a_supply_pin_without_a_capacitor() {
    for (capacitor, chip) in [
        ("C4", "U1"),
        ("C8", "U3"),
        ("C9", "U4"),
        ("C15", "U5"),
        ("C16", "U6"),
        ("C20", "U7"),
    ] {
        found(
            |d| remove(d, capacitor),
            Rule::Decoupling,
            &format!("{chip} has no capacitor"),
        );
    }
}

#[test]
fn a_leg_without_a_clamp() {
    found(
        |d| remove(d, "D3"),
        Rule::Clamps,
        "LEG_A: MA reaches -1.0 V",
    );
    found(
        |d| remove(d, "D4"),
        Rule::Clamps,
        "LEG_B: MB reaches -1.0 V",
    );
    found(|d| remove(d, "D6"), Rule::Clamps, "SERVO: SERVO_IN");
}

#[test]
fn connectors_without_their_headers() {
    found(
        |d| remove(d, "P11"),
        Rule::Headers,
        "actuator: 1 of 2 parts of type header-70",
    );
    found(
        |d| remove(d, "J12"),
        Rule::Headers,
        "actuator: 1 of 2 parts of type socket-70",
    );
}

#[test]
fn a_zio_number_where_a_morpho_number_is_meant() {
    found(
        |d| {
            disconnect(d, &["A1.CN12-52"]);
            connect(d, "AH", "A1", "CN10-4");
        },
        Rule::Connections,
        "A1 has no pin CN10-4: a pin of the Zio connectors; PE9 is CN12-52",
    );
}

#[test]
fn a_pin_of_the_processor_used_twice() {
    let change = |d: &mut Design| {
        let pin = d.processor.iter_mut().find(|pin| pin.name == "LEG_B");
        let pin = pin.expect("a pin");
        pin.pin = "PC0".to_owned();
        pin.peripheral = "ADC1_IN10".to_owned();
    };
    found(
        change,
        Rule::Processor,
        "PC0 (ADC1_IN10, LEG_B) is used twice: leg A, leg B",
    );
}

#[test]
fn a_function_that_the_pin_does_not_have() {
    let change = |d: &mut Design| {
        let pin = d.processor.iter_mut().find(|pin| pin.name == "BREAK");
        pin.expect("a pin").alternate = Some(3);
    };
    found(change, Rule::Processor, "PE15 has no function TIM1_BKIN:3");
}

#[test]
fn a_serial_line_at_the_debugger() {
    found(
        |d| set_kind(d, "A11", "ST-LINK"),
        Rule::Serial,
        "ST-LINK is at the serial line",
    );
}

#[test]
fn a_pin_on_two_nets() {
    found(
        |d| connect(d, "GND", "U3", "8"),
        Rule::Connections,
        "U3.8 is on 2 nets",
    );
}

#[test]
fn transistors_that_need_more_voltage_at_their_gates() {
    // The clamp of 9 V reaches 14.4 V; the transistors withstand 12 V.
    let change = |d: &mut Design| set_kind(d, "D1", "SMAJ9.0A");
    found(change, Rule::Gates, "Q1 withstands 12 V at its gate");
}

#[test]
fn a_threshold_that_trips_in_normal_operation() {
    found(
        |d| set_value(d, "R11", 47e3),
        Rule::Trip,
        "the comparator may trip at",
    );
    found(
        |d| set_value(d, "R11", 20e3),
        Rule::Trip,
        "the amplifier reads to",
    );
}

#[test]
fn a_switch_that_nothing_opens_in_reset() {
    found(|d| remove(d, "R4"), Rule::Gates, "leg B, high side (PE11)");
}

#[test]
fn resistors_too_weak_to_hold_the_floating_motor() {
    let change = |d: &mut Design| {
        for designator in ["R19", "R21", "R27", "R28"] {
            set_value(d, designator, 30e3);
        }
    };
    found(change, Rule::Ranges, "the lower leg is at");
}

#[test]
fn a_divider_beyond_the_reference() {
    found(
        |d| set_value(d, "R15", 5.1e3),
        Rule::Ranges,
        "LEG_A reaches",
    );
    found(
        |d| set_value(d, "R23", 12e3),
        Rule::Ranges,
        "V_SENSE reads at most",
    );
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
