//! Pins of the processor, the connectors between the boards, and the serial line.

use super::{Findings, Rule};
use crate::{Design, ProcessorPin};

pub(super) fn check(design: &Design, findings: &mut Findings) {
    for (index, pin) in design.processor.iter().enumerate() {
        function(design, pin, findings);
        let is_same = |other: &&ProcessorPin| {
            other.board == pin.board
                && (other.pin == pin.pin
                    || other.peripheral == pin.peripheral && pin.mode != "output"
                    || other.name == pin.name)
        };
        let before = design.processor.iter().take(index).find(is_same);
        findings.expect(Rule::Processor, before.is_none(), || {
            let other = before.map_or("", |other| other.function.as_str());
            format!(
                "{} ({}, {}) is used twice: {other}, {}",
                pin.pin, pin.peripheral, pin.name, pin.function
            )
        });
    }
    headers(design, findings);
    serial(design, findings);
}

/// The pin has the function, and is on a net at its connector.
fn function(design: &Design, pin: &ProcessorPin, findings: &mut Findings) {
    let row = design.functions.iter().find(|row| row.pin == pin.pin);
    let expected = match pin.alternate {
        Some(number) => format!("{}:{number}", pin.peripheral),
        None => pin.peripheral.clone(),
    };
    let has_it = pin.mode == "output"
        || row.is_some_and(|row| {
            row.functions
                .split_whitespace()
                .any(|found| found == expected)
        });
    findings.expect(Rule::Processor, has_it, || {
        format!("{} has no function {expected}", pin.pin)
    });
    let at = design.connectors.iter().find(|row| row.name == pin.pin);
    let board = design
        .parts
        .iter()
        .find(|part| part.board == pin.board && part.designator.starts_with('A'));
    let is_connected = at
        .zip(board)
        .is_some_and(|(at, board)| design.net_at(&board.designator, &at.morpho).is_some());
    findings.expect(Rule::Processor, is_connected, || {
        format!("{} ({}) is on no net", pin.pin, pin.function)
    });
}

/// The Morpho connectors of a Nucleo are holes: each board needs two headers to solder into them,
/// and a board that is plugged on needs two sockets.
fn headers(design: &Design, findings: &mut Findings) {
    for (board, kinds) in [
        ("actuator", &["header-70", "socket-70"][..]),
        ("comm", &["header-70"]),
    ] {
        for kind in kinds {
            let is_one = |part: &&crate::Part| part.board == board && part.kind == *kind;
            let count = design.parts.iter().filter(is_one).count();
            findings.expect(Rule::Headers, count == 2, || {
                format!("{board}: {count} of 2 parts of type {kind} for CN11 and CN12")
            });
        }
    }
}

/// What is at the other end of the serial line supports its speed.
fn serial(design: &Design, findings: &mut Findings) {
    let baud = design.figure("comm", "baud");
    let net = design.net("comm", "SERIAL_TX");
    let ends = net.map_or(&[][..], |net| &net.pins);
    let adapter = ends
        .iter()
        .filter_map(|(part, _)| design.part(part))
        .find(|part| part.kind != "NUCLEO-F429ZI");
    let greatest = adapter.map_or(f64::NAN, |part| design.figure(&part.kind, "baud"));
    findings.expect(Rule::Serial, baud <= greatest, || {
        let kind = adapter.map_or("nothing", |part| part.kind.as_str());
        format!("{kind} is at the serial line; {baud} baud are documented for no such adapter")
    });
}
