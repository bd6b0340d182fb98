//! Each net has the function that a chain of `chains.csv` gives it, and each pin is in one.
//!
//! A chain begins at a supply or at a pin of the processor, by its function, and follows the parts
//! by the functions of their pins, whatever their designators and the names of the nets are:
//!
//! ```text
//! LEG_A_HIGH IN_A>OUT_A resistor[4.7:22] GP>SP VM
//! ```
//!
//! `IN>OUT` enters a part at the pin `IN` and leaves it at `OUT`, `kind[least:most]` passes a part
//! with two terminals, and the last word is a supply, a pin of the processor or `kind:pin`.

use std::collections::HashSet;

use super::{Findings, Rule};
use crate::design::{Design, Net, PinOf};
use crate::rows::{Chain, Electrical};

/// Designators and pins that chains pass.
type Passed = HashSet<(String, String)>;

pub(super) fn check(design: &Design, findings: &mut Findings) {
    let mut passed = Passed::new();
    for chain in &design.chains {
        let holds = holds(design, chain, &mut passed);
        findings.expect(Rule::Functions, holds, || {
            format!(
                "{}: no chain {}: {}",
                chain.board, chain.chain, chain.purpose
            )
        });
    }
    for net in &design.nets {
        for found in design.pins_on(net) {
            let place = (found.part.designator.clone(), found.pin.pin.clone());
            let is_in_chain = has_other_rule(&found) || passed.contains(&place);
            findings.expect(Rule::Functions, is_in_chain, || {
                format!(
                    "{}.{} ({}) is on {}, in no chain of chains.csv",
                    place.0, place.1, found.pin.name, net.name
                )
            });
        }
    }
    for part in &design.parts {
        same_part(&design.pins_of(part), findings);
    }
}

/// Supply pins, straps and their capacitors are the business of other rules.
fn has_other_rule(found: &PinOf<'_>) -> bool {
    use Electrical::{Ground, Power, Strap, Supply};
    let is_capacitor = found.part.kind == "capacitor" && !found.part.at.is_empty();
    is_capacitor || [Ground, Power, Strap, Supply].contains(&found.pin.electrical)
}

/// Pins of a part with one name are on one net, and pins with different names on different ones.
/// The drains of both transistors in a part are the leg.
fn same_part(pins: &[PinOf<'_>], findings: &mut Findings) {
    let counted = |found: &&PinOf<'_>| !has_other_rule(found) && found.net.is_some();
    for (index, one) in pins.iter().enumerate().filter(|(_, found)| counted(found)) {
        for other in pins.iter().skip(index + 1).filter(counted) {
            let is_drain = |found: &PinOf<'_>| found.pin.electrical == Electrical::Drain;
            let is_joined = one.pin.name == other.pin.name || is_drain(one) && is_drain(other);
            let is_return = one.part.designator.starts_with('J')
                && one.net.is_some_and(|net| net.name == "GND");
            let holds = is_return || is_joined == (one.net == other.net);
            findings.expect(Rule::Functions, holds, || {
                let net = |found: &PinOf<'_>| found.net.map_or("", |net| &net.name).to_owned();
                format!(
                    "{}: pins {} and {} are on {} and {}",
                    one.part.designator,
                    one.pin.name,
                    other.pin.name,
                    net(one),
                    net(other)
                )
            });
        }
    }
}

fn holds(design: &Design, chain: &Chain, passed: &mut Passed) -> bool {
    let words: Vec<&str> = chain.chain.split_whitespace().collect();
    let Some((first, rest)) = words.split_first() else {
        return false;
    };
    let Some((start, place)) = named(design, &chain.board, first) else {
        return false;
    };
    passed.extend(place);
    follow(design, start, rest, passed)
}

/// The net of a supply, or that of a pin of the processor and the pin.
fn named<'a>(
    design: &'a Design,
    board: &str,
    name: &str,
) -> Option<(&'a Net, Option<(String, String)>)> {
    let mut used = design.processor.iter();
    let Some(pin) = used.find(|pin| pin.board == board && pin.name == name) else {
        let rail = design.net(board, name);
        return rail
            .filter(|_| design.range(board, name).is_some())
            .map(|net| (net, None));
    };
    let morpho = &design
        .connectors
        .iter()
        .find(|row| row.name == pin.pin)?
        .morpho;
    let is_processor = |net: &&Net| {
        let mut pins = net.pins.iter();
        pins.any(|(part, at)| at == morpho && part.starts_with('A'))
    };
    let net = design.nets_of(board).find(is_processor)?;
    let (part, _) = net
        .pins
        .iter()
        .find(|(part, at)| at == morpho && part.starts_with('A'))?;
    Some((net, Some((part.clone(), morpho.clone()))))
}

/// Whether the rest of a chain leads from a net to its end; adds the pins of all ways that do.
fn follow(design: &Design, net: &Net, words: &[&str], passed: &mut Passed) -> bool {
    let Some((word, rest)) = words.split_first() else {
        return true;
    };
    if let Some((end, place)) = named(design, &net.board, word) {
        passed.extend(place);
        return end == net;
    }
    let mut holds = false;
    for entry in design.pins_on(net) {
        let exits = exits(design, &entry, word);
        for (exit, next) in exits {
            // A supply ends a chain: it is common to all that is at it.
            let is_end = rest
                .iter()
                .all(|word| named(design, &net.board, word).is_some());
            if (is_end || !is_supply(design, next)) && follow(design, next, rest, passed) {
                holds = true;
                for pin in [&entry, &exit] {
                    passed.insert((pin.part.designator.clone(), pin.pin.pin.clone()));
                }
            }
        }
    }
    holds
}

/// Whether a net supplies parts, or is their ground.
fn is_supply(design: &Design, net: &Net) -> bool {
    use Electrical::{Ground, Power, Supply};
    let pins = design.pins_on(net);
    let mut pins = pins.iter().map(|found| found.pin.electrical);
    pins.any(|electrical| [Ground, Power, Supply].contains(&electrical))
}

/// The pins at which a word of a chain leaves the part of a pin, with their nets.
fn exits<'a>(design: &'a Design, entry: &PinOf<'a>, word: &str) -> Vec<(PinOf<'a>, &'a Net)> {
    let leave = |is_exit: &dyn Fn(&PinOf<'_>) -> bool| {
        let pins = design
            .pins_of(entry.part)
            .into_iter()
            .filter(|pin| is_exit(pin));
        pins.filter_map(|pin| pin.net.map(|net| (pin, net)))
            .collect()
    };
    if let Some((kind, range)) = word.strip_suffix(']').and_then(|word| word.split_once('[')) {
        if entry.part.kind == kind && is_in(entry.part.value, range) {
            return leave(&|pin| pin.pin.pin != entry.pin.pin);
        }
    } else if let Some((enter, exit)) = word.split_once('>') {
        if entry.pin.name == enter {
            return leave(&|pin| pin.pin.name == exit);
        }
    } else {
        let (kind, name) = word.split_once(':').unwrap_or((&entry.part.kind, word));
        if entry.part.kind == kind && entry.pin.name == name {
            return leave(&|pin| pin.pin.pin == entry.pin.pin);
        }
    }
    Vec::new()
}

/// Whether a value is in a range as `4.7:22`; without one every value is.
fn is_in(value: Option<f64>, range: &str) -> bool {
    let Some((least, most)) = range.split_once(':') else {
        return range.is_empty();
    };
    let [Ok(least), Ok(most)] = [least, most].map(str::parse::<f64>) else {
        return false;
    };
    value.is_some_and(|value| least <= value && value <= most)
}
