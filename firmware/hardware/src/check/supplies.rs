//! Supply pins are in their ranges and decoupled, capacitors and clamps are rated for their nets.

use super::{Findings, Rule};
use crate::design::{Design, PinOf};
use crate::{Electrical, Part};

/// Least capacitance at a supply pin, F.
const DECOUPLING_F: f64 = 100e-9;

pub(super) fn check(design: &Design, findings: &mut Findings) {
    for part in &design.parts {
        for found in design.pins_of(part) {
            if found.pin.electrical == Electrical::Power && found.net.is_some() {
                range(design, &found, findings);
                decoupling(design, &found, findings);
            }
            if found.pin.electrical == Electrical::Ground {
                let net = found.net.map(|net| net.name.as_str());
                findings.expect(Rule::Supplies, net.is_none_or(|net| net == "GND"), || {
                    format!(
                        "{}.{} (ground) is on {net:?}",
                        part.designator, found.pin.pin
                    )
                });
            }
        }
        if part.kind.starts_with("capacitor") {
            rating(design, part, findings);
        }
    }
    clamp(design, findings);
}

fn range(design: &Design, found: &PinOf<'_>, findings: &mut Findings) {
    let (part, pin) = (found.part, &found.pin);
    let Some(net) = found.net else { return };
    let range = design.range(&part.board, &net.name);
    let (min_v, max_v) = (pin.min_v.unwrap_or(f64::NAN), pin.max_v.unwrap_or(f64::NAN));
    let absolute_v = pin.absolute_v.unwrap_or(max_v);
    let holds = range.is_some_and(|range| {
        min_v <= range.low_v && range.high_v <= max_v && range.surge_v <= absolute_v
    });
    findings.expect(Rule::Supplies, holds, || {
        let supply = range.map_or("no supply".to_owned(), |range| {
            format!("{:.2} to {:.2} V, {:.1} V for a moment", range.low_v, range.high_v, range.surge_v)
        });
        format!(
            "{}.{} ({}): {} has {supply}; the part needs {min_v} to {max_v} V, at most {absolute_v} V",
            part.designator, pin.pin, pin.name, net.name
        )
    });
}

fn decoupling(design: &Design, found: &PinOf<'_>, findings: &mut Findings) {
    let Some(net) = found.net else { return };
    let is_here = |capacitor: &&Part| {
        let nets = ["1", "2"].map(|pin| design.net_at(&capacitor.designator, pin));
        capacitor.at == found.part.designator
            && capacitor.value >= Some(DECOUPLING_F)
            && nets[0] == Some(net)
            && nets[1].is_some_and(|net| net.name == "GND")
    };
    findings.expect(
        Rule::Decoupling,
        design.parts.iter().any(|part| is_here(&part)),
        || {
            let (part, pin) = (&found.part.designator, &found.pin.name);
            format!(
                "{part} has no capacitor of 100 nF or more between {pin} ({}) and ground",
                net.name
            )
        },
    );
}

/// A capacitor withstands the greatest voltage of its net.
fn rating(design: &Design, part: &Part, findings: &mut Findings) {
    let net = design.net_at(&part.designator, "1");
    let Some(range) = net.and_then(|net| design.range(&part.board, &net.name)) else {
        return;
    };
    let rated_v: f64 = part
        .rating
        .trim_end_matches(" V")
        .parse()
        .unwrap_or(f64::NAN);
    findings.expect(Rule::Supplies, rated_v >= range.surge_v, || {
        format!(
            "{} is rated {}; its net reaches {} V",
            part.designator, part.rating, range.surge_v
        )
    });
}

/// The clamp does not conduct at a voltage at which the program still drives, and a full battery
/// is below its standoff voltage.
fn clamp(design: &Design, findings: &mut Findings) {
    let kind = design.part("D1").map_or("", |part| part.kind.as_str());
    let full_v = design.figure("battery", "highest");
    let standoff_v = design.figure(kind, "standoff");
    findings.expect(Rule::Supplies, full_v <= standoff_v, || {
        format!("D1 stands off {standoff_v} V; a full battery has {full_v} V")
    });
    let high_v = design
        .range("actuator", "VM")
        .map_or(f64::NAN, |range| range.high_v);
    let breakdown_v = design.figure(kind, "breakdown");
    findings.expect(Rule::Supplies, high_v <= breakdown_v, || {
        format!("D1 conducts from {breakdown_v} V; the program drives up to {high_v:.2} V")
    });
}
