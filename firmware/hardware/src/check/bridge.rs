//! Transistors and comparator of the bridge.

use super::{Findings, Rule};
use crate::design::{Design, Range};
use crate::{Electrical, Part};

pub(super) fn check(design: &Design, findings: &mut Findings) {
    let Some(supply) = design.range("actuator", "VM") else {
        return findings.expect(Rule::Gates, false, || "VM has no range".to_owned());
    };
    for part in &design.parts {
        let pins = design.pins_of(part);
        if pins
            .iter()
            .any(|found| found.pin.electrical == Electrical::Gate)
        {
            transistor(design, part, supply, findings);
        }
    }
    off_in_reset(design, findings);
    trip(design, findings);
}

/// All gates swing between ground and VM, and so do the drains.
fn transistor(design: &Design, part: &Part, supply: Range, findings: &mut Findings) {
    let [drive_v, gate_v, drain_v, current_a] =
        ["gate_drive", "gate_absolute", "drain_absolute", "current"]
            .map(|figure| design.figure(&part.kind, figure));
    let name = &part.designator;
    findings.expect(Rule::Gates, drive_v <= supply.low_v, || {
        format!(
            "{name} is specified from {drive_v} V at its gate; VM falls to {:.2} V",
            supply.low_v
        )
    });
    findings.expect(Rule::Gates, supply.surge_v <= gate_v.min(drain_v), || {
        format!(
            "{name} withstands {gate_v} V at its gate; VM reaches {} V",
            supply.surge_v
        )
    });
    let trip_a = design.trip_range_a().1;
    findings.expect(Rule::Gates, trip_a <= current_a, || {
        format!("{name} carries {current_a} A; the comparator trips at up to {trip_a:.2} A")
    });
}

/// Resistors hold the inputs of the gate drivers at ground while the processor's pins are inputs.
fn off_in_reset(design: &Design, findings: &mut Findings) {
    for pin in design
        .processor
        .iter()
        .filter(|pin| pin.peripheral.starts_with("TIM1_CH"))
    {
        let row = design.connectors.iter().find(|row| row.name == pin.pin);
        let net = row.and_then(|row| design.net_at("A1", &row.morpho));
        let is_held = net.is_some_and(|net| {
            design
                .across(net, "resistor")
                .any(|(_, other)| other.name == "GND")
        });
        findings.expect(Rule::Gates, is_held, || {
            format!(
                "{} ({}): no resistor opens the switch in reset",
                pin.function, pin.pin
            )
        });
    }
}

/// The comparator trips above what the program limits and what a reversal at the full rate takes,
/// and below what the amplifier can still measure. It cannot detect a runaway: a motor that turns
/// freely takes less than one that stalls.
fn trip(design: &Design, findings: &mut Findings) {
    let (low_a, high_a) = design.trip_range_a();
    let limit = design.limit("over_current_ma");
    let program_a = limit.map_or(f64::NAN, |limit| limit.default as f64 / 1000.0);
    let working_a = design.figure("motor", "reversal_current").max(program_a);
    findings.expect(Rule::Trip, working_a <= low_a, || {
        format!("the comparator may trip at {low_a:.2} A; the program allows {working_a} A")
    });
    let greatest_a = design.greatest_current_a();
    findings.expect(Rule::Trip, high_a <= greatest_a, || {
        format!(
            "the comparator trips at up to {high_a:.2} A; the amplifier reads to {greatest_a:.2} A"
        )
    });
    let kind = design.part("U4").map_or("", |part| part.kind.as_str());
    let filter_s = design.value("R13") * design.value("C3");
    let delay_s = filter_s + design.figure(kind, "delay");
    findings.expect(Rule::Trip, delay_s <= 1e-6, || {
        format!(
            "filter and comparator take {:.2} us; 1 us is documented",
            delay_s * 1e6
        )
    });
}
