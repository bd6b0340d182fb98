//! The servo bus: edges, levels and currents.

use super::{Findings, Rule};
use crate::design::Design;

pub(super) fn check(design: &Design, findings: &mut Findings) {
    let bus = design.servo_bus();
    pin(design, findings);
    // The level is sampled in the middle of a bit.
    findings.expect(Rule::ServoBus, bus.rise_s <= bus.half_bit_s, || {
        format!(
            "the bus rises in {:.0} ns; half a bit is {:.0} ns",
            bus.rise_s * 1e9,
            bus.half_bit_s * 1e9
        )
    });
    findings.expect(Rule::ServoBus, bus.low_v <= bus.reads_low_v, || {
        format!(
            "a servo that drives low leaves {:.2} V at the pin, which reads {:.2} V as low",
            bus.low_v, bus.reads_low_v
        )
    });
    let rated_a = design.figure("STM32F429ZI", "low_current");
    findings.expect(Rule::ServoBus, bus.sunk_a <= rated_a, || {
        format!(
            "the pin sinks {:.1} mA; its low level is specified up to {:.1} mA",
            bus.sunk_a * 1e3,
            rated_a * 1e3
        )
    });
    let tolerated_v = design.figure("STM32F429ZI", "tolerant_absolute");
    findings.expect(Rule::ServoBus, bus.highest_v <= tolerated_v, || {
        format!(
            "the bus reaches {} V; the pin tolerates {tolerated_v} V",
            bus.highest_v
        )
    });
}

/// The pin only pulls low. Its edges are fast, as those of low speed take up to 100 ns, and its
/// internal resistors are off, as a pin above its supply requires.
fn pin(design: &Design, findings: &mut Findings) {
    let mut pins = design.processor.iter();
    let pin = pins.find(|pin| pin.name == "SERVO_BUS");
    let settings = pin.map_or(["none"; 3], |pin| [&pin.mode, &pin.speed, &pin.pull]);
    findings.expect(
        Rule::ServoBus,
        settings == ["open drain", "high", ""],
        || format!("SERVO_BUS: mode, speed and pull are {settings:?}"),
    );
}
