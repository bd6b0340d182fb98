//! The design is sound, and the committed files are those that it generates.

use std::fs;
use std::path::Path;

use board_design::{Design, check, write};

#[test]
fn the_committed_design_passes_the_check() {
    let findings = check::check(&Design::read().expect("valid files"));
    assert_eq!(findings, []);
}

#[test]
fn tables_schematic_list_of_parts_figures_and_pins_are_those_of_the_design() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let design = Design::read().expect("valid files");
    for (path, text) in write::files(&design, &root).expect("the document has its markers") {
        let committed = fs::read_to_string(root.join(path)).unwrap_or_default();
        assert!(
            committed == text,
            "{path} is out of date: cargo run -p board-design"
        );
    }
}

#[test]
fn the_texts_state_the_figures_of_the_design() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let design = Design::read().expect("valid files");
    let trip_a = format!("{:.2} A", design.trip_a());
    let nominal = format!("{:.0} mV", design.trip_a() * design.value("R1") * 1e3);
    let (low_v, high_v) = design.threshold_range_v();
    let bounds = format!("{:.0} to {:.0} mV", low_v * 1e3, high_v * 1e3);
    let motor = |figure| format!("{:.2} A", design.figure("motor", figure));
    let limit = design.limit("under_voltage_mv").expect("a limit");
    let lowest = format!("{:.1} V as measured", limit.default as f64 / 1e3);
    let driver = design
        .pins
        .iter()
        .find(|pin| pin.kind == "LM5111-4" && pin.name == "VCC");
    let driver_v = driver.and_then(|pin| pin.min_v).expect("a range");
    let gate_v = design.figure("IRF7307", "gate_drive");
    let needs = format!("{driver_v} and {gate_v} V");
    let bus = design.servo_bus();
    let ns = |seconds: f64| format!("{:.0} ns", seconds * 1e9);
    let ma = |ampere: f64| format!("{:.1} mA", ampere * 1e3);
    let hardware = vec![
        ns(bus.rise_s),
        ns(bus.half_bit_s),
        format!("{:.2} V at PB6", bus.low_v),
        format!("{:.2} V as low", bus.reads_low_v),
        ma(bus.sunk_a),
        ma(bus.returned_a),
        format!("{:.2} A", bus.opposed_a),
        nominal,
        bounds,
        motor("stall_current"),
        motor("reversal_current"),
        lowest,
        needs,
    ];
    for (path, texts) in [
        ("docs/faults.md", vec![trip_a.clone()]),
        ("docs/glossary.md", vec![trip_a]),
        ("docs/hardware.md", hardware),
    ] {
        let document = fs::read_to_string(root.join(path)).expect("a document");
        for text in texts {
            assert!(document.contains(&text), "{path} does not state {text}");
        }
    }
}

#[test]
fn a_change_of_a_figure_reaches_document_model_and_pins() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut design = Design::read().expect("valid files");
    let before = write::files(&design, &root).expect("files");
    design.part_mut("R10").expect("the shunt").value = Some(0.008);
    let pin = design.processor.iter_mut().find(|pin| pin.name == "SUPPLY");
    let pin = pin.expect("a pin");
    pin.pin = "PA7".to_owned();
    pin.peripheral = "ADC1_IN7".to_owned();
    let after = write::files(&design, &root).expect("files");
    let changed = |path: &str, text: &str| {
        let of = |files: &[(&'static str, String)]| {
            let file = files.iter().find(|(name, _)| *name == path);
            file.expect("a file").1.contains(text)
        };
        assert!(!of(&before) && of(&after), "{path}: {text}");
    };
    changed("docs/hardware.md", "0.4 V/A around 1.65 V");
    changed("docs/hardware.md", "| supply | PA7 | CN12-15 | ADC1_IN7 |");
    changed("docs/hardware/actuator-board.svg", "8 mohm");
    changed("docs/hardware/actuator-board-parts.csv", "8 mohm");
    changed(
        "model-core/src/sensors/board_figures.rs",
        "CURRENT_GAIN_V_A: f64 = 0.4;",
    );
    changed(
        "firmware/boards/shared/actuator/pins.rs",
        "pub const SUPPLY: u8 = 7;",
    );
}
