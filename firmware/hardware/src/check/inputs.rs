//! Voltages from outside the supplies are limited at the processor's pins.

use super::{Findings, Rule};
use crate::design::{Design, LOGIC_V, Net};

/// The clamp: two Schottky diodes in series between ground and supply.
const CLAMP: &str = "BAS70-04";

pub(super) fn check(design: &Design, findings: &mut Findings) {
    for net in &design.nets {
        let Some(range) = design.range(&net.board, &net.name) else {
            continue;
        };
        let is_below_ground = range.low_v < 0.0;
        for (resistor, inside) in design.across(net, "resistor") {
            let is_supply = design.range(&inside.board, &inside.name).is_some();
            if !is_below_ground || is_supply || !reaches_processor(design, inside) {
                continue;
            }
            findings.expect(Rule::Clamps, is_clamped(design, inside), || {
                format!(
                    "{}: {} reaches {:.1} V, and no {CLAMP} limits it",
                    inside.name, net.name, range.low_v
                )
            });
            let highest_v = LOGIC_V + design.figure(CLAMP, "forward");
            let injected_a = (range.surge_v - highest_v) / resistor.value.unwrap_or(f64::NAN);
            let allowed_a = design.figure("STM32F429ZI", "injection");
            findings.expect(Rule::Clamps, injected_a <= allowed_a, || {
                format!(
                    "{}: {:.1} mA flow into the supply",
                    inside.name,
                    injected_a * 1e3
                )
            });
            let pin_v = design.figure("STM32F429ZI", "pin_absolute");
            findings.expect(Rule::Clamps, highest_v <= pin_v, || {
                format!(
                    "{}: clamped at {highest_v:.2} V; the pin withstands {pin_v} V",
                    inside.name
                )
            });
        }
    }
}

fn reaches_processor(design: &Design, net: &Net) -> bool {
    net.pins.iter().any(|(part, _)| {
        design
            .part(part)
            .is_some_and(|part| part.designator.starts_with('A'))
    })
}

fn is_clamped(design: &Design, net: &Net) -> bool {
    net.pins.iter().any(|(designator, pin)| {
        let end = |pin| design.net_at(designator, pin).map(|net| net.name.as_str());
        let is_clamp = design
            .part(designator)
            .is_some_and(|part| part.kind == CLAMP);
        is_clamp && pin == "3" && end("1") == Some("GND") && end("2") == Some("3V3")
    })
}
