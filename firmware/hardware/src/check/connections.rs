//! Every pin is on one net or may stay open.

use std::collections::HashMap;

use super::{Findings, Rule};
use crate::{Design, Electrical};

pub(super) fn check(design: &Design, findings: &mut Findings) {
    let mut uses: HashMap<(&str, &str), usize> = HashMap::new();
    for net in &design.nets {
        findings.expect(Rule::Connections, net.pins.len() > 1, || {
            format!("net {}: fewer than two pins", net.name)
        });
        for (designator, pin) in &net.pins {
            *uses.entry((designator, pin)).or_default() += 1;
            let part = design.part(designator);
            let is_known = part.is_some_and(|part| {
                part.board == net.board
                    && design
                        .pins_of(part)
                        .iter()
                        .any(|found| found.pin.pin == *pin)
            });
            findings.expect(Rule::Connections, is_known, || {
                let hint = design.connectors.iter().find(|row| row.zio == *pin);
                let hint = hint.map_or(String::new(), |row| {
                    format!(
                        ": a pin of the Zio connectors; {} is {}",
                        row.name, row.morpho
                    )
                });
                format!("net {}: {designator} has no pin {pin}{hint}", net.name)
            });
        }
    }
    for ((designator, pin), count) in uses {
        findings.expect(Rule::Connections, count == 1, || {
            format!("{designator}.{pin} is on {count} nets")
        });
    }
    for part in &design.parts {
        let is_mechanical = ["socket-70", "header-70"].contains(&part.kind.as_str());
        let pins = design.pins_of(part);
        findings.expect(Rule::Connections, is_mechanical || !pins.is_empty(), || {
            format!("{}: no pins of {} are known", part.designator, part.kind)
        });
        for found in &pins {
            let is_open = found.pin.electrical == Electrical::Open;
            findings.expect(Rule::Connections, is_open || found.net.is_some(), || {
                let (part, pin) = (&part.designator, &found.pin);
                format!("{part}.{} ({}) is not connected", pin.pin, pin.name)
            });
        }
    }
}
