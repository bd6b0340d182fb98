//! The electrical rule check.

mod analog;
mod bridge;
mod chains;
mod connections;
mod drivers;
mod inputs;
mod processor;
mod servo_bus;
mod supplies;
mod values;

use std::fmt;

use crate::Design;

/// The rule that a finding breaks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rule {
    /// Every pin is on one net or may stay open, and exists.
    Connections,
    /// Every supply pin is in its range; each supply has its capacitor.
    Supplies,
    /// A capacitor close to each supply pin.
    Decoupling,
    /// One push-pull output a net; a resistor to a supply at open drains, and only there.
    Outputs,
    /// Configuration inputs are tied.
    Straps,
    /// What is measured stays readable up to every limit of the program.
    Ranges,
    /// Threshold of the comparator.
    Trip,
    /// Gates get the voltage for which the transistors are specified, and no more than they
    /// withstand.
    Gates,
    /// Voltages from outside are limited at the processor's pins.
    Clamps,
    /// Pins of the processor: used once, with a function that they have, at their connector.
    Processor,
    /// Connectors that the boards are joined by.
    Headers,
    /// Speed of the serial line.
    Serial,
    /// Edges, levels and currents of the servo bus.
    ServoBus,
    /// Nets lead from the processor and the supplies to the pins with their functions.
    Functions,
    /// Time constants and ratings.
    Values,
}

/// An error of the design.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// The rule.
    pub rule: Rule,
    /// Where, what was found and what was expected.
    pub text: String,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}: {}", self.rule, self.text)
    }
}

/// What the checks found.
#[derive(Default)]
struct Findings(Vec<Finding>);

impl Findings {
    /// Adds a finding unless `holds`. A comparison with an unknown figure, `NaN`, does not hold.
    fn expect(&mut self, rule: Rule, holds: bool, text: impl FnOnce() -> String) {
        if !holds {
            self.0.push(Finding { rule, text: text() });
        }
    }
}

/// All errors of the design; none, if it is sound.
#[must_use]
pub fn check(design: &Design) -> Vec<Finding> {
    let mut findings = Findings::default();
    connections::check(design, &mut findings);
    supplies::check(design, &mut findings);
    drivers::check(design, &mut findings);
    bridge::check(design, &mut findings);
    analog::check(design, &mut findings);
    inputs::check(design, &mut findings);
    processor::check(design, &mut findings);
    servo_bus::check(design, &mut findings);
    chains::check(design, &mut findings);
    values::check(design, &mut findings);
    findings.0
}
