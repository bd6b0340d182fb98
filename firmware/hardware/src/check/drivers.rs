//! Outputs do not oppose each other, open drains have a resistor to a supply, and configuration
//! inputs are tied.

use super::{Findings, Rule};
use crate::Electrical;
use crate::design::{Design, LOGIC_V, Net, PinOf};

pub(super) fn check(design: &Design, findings: &mut Findings) {
    for net in &design.nets {
        outputs(design, net, findings);
    }
    for part in &design.parts {
        for found in design.pins_of(part) {
            if found.pin.electrical == Electrical::Strap {
                strap(&found, findings);
            }
        }
    }
    break_input(design, findings);
}

fn of_type<'a>(pins: &'a [PinOf<'a>], electrical: Electrical) -> Vec<&'a PinOf<'a>> {
    let is_of = |found: &&PinOf<'_>| found.pin.electrical == electrical;
    pins.iter().filter(is_of).collect()
}

fn outputs(design: &Design, net: &Net, findings: &mut Findings) {
    let pins = design.pins_on(net);
    let push_pull = of_type(&pins, Electrical::Output);
    let open_drain = of_type(&pins, Electrical::OpenDrain);
    let is_opposed = push_pull.len() > 1 || !push_pull.is_empty() && !open_drain.is_empty();
    findings.expect(Rule::Outputs, !is_opposed, || {
        format!("net {}: outputs drive against each other", net.name)
    });
    let is_supply = |other: &Net| {
        other.name != "GND"
            && design
                .range(&other.board, &other.name)
                .is_some_and(|r| r.low_v > 0.0)
    };
    let mut resistors = design.across(net, "resistor");
    let pull_up = resistors.find(|(_, other)| is_supply(other));
    findings.expect(
        Rule::Outputs,
        open_drain.is_empty() || pull_up.is_some(),
        || {
            format!(
                "net {}: no resistor to a supply at an open-drain output",
                net.name
            )
        },
    );
    // A pin of the processor is an input in reset, so that a resistor decides its level there.
    let chip = push_pull
        .iter()
        .find(|found| found.part.designator.starts_with('U'));
    if let (Some(chip), Some((resistor, _))) = (chip, pull_up) {
        findings.expect(Rule::Outputs, false, || {
            format!(
                "net {}: {} ({}) drives it high, where {} is to hold it: an output with open drain is meant",
                net.name, chip.part.designator, chip.part.kind, resistor.designator
            )
        });
    }
    let needs_driver = !of_type(&pins, Electrical::Input).is_empty();
    let passive = !of_type(&pins, Electrical::Passive).is_empty();
    let is_driven = passive || !push_pull.is_empty() || !open_drain.is_empty();
    findings.expect(Rule::Outputs, !needs_driver || is_driven, || {
        format!("net {}: nothing drives its inputs", net.name)
    });
}

fn strap(found: &PinOf<'_>, findings: &mut Findings) {
    let net = found.net.map(|net| net.name.as_str());
    findings.expect(Rule::Straps, net == Some(&found.pin.tie), || {
        let (part, pin) = (&found.part.designator, &found.pin);
        format!(
            "{part}.{} ({}) must be tied to {}, is on {net:?}",
            pin.pin, pin.name, pin.tie
        )
    });
}

/// The resistor at the break input overcomes the processor's own pull-down, which holds the bridge
/// off when the board of the bridge is missing.
fn break_input(design: &Design, findings: &mut Findings) {
    let Some(net) = design.net("actuator", "BREAK_N") else {
        return findings.expect(Rule::Outputs, false, || {
            "there is no net BREAK_N".to_owned()
        });
    };
    let up_ohm = design
        .across(net, "resistor")
        .filter_map(|(part, _)| part.value)
        .next();
    let down_ohm = design.figure("STM32F429ZI", "pull_min");
    let level_v = up_ohm.map_or(0.0, |up_ohm| LOGIC_V * down_ohm / (up_ohm + down_ohm));
    let high_v = LOGIC_V * design.figure("STM32F429ZI", "input_high_share");
    findings.expect(Rule::Outputs, level_v >= high_v, || {
        format!("BREAK_N rises to {level_v:.2} V; the processor reads {high_v:.2} V as high")
    });
}
