//! What the program measures stays readable up to every limit that it compares with.

use super::{Findings, Rule};
use crate::Divider;
use crate::design::{Design, LOGIC_V};

pub(super) fn check(design: &Design, findings: &mut Findings) {
    currents(design, findings);
    let greatest_mv = design
        .limits
        .iter()
        .filter(|limit| limit.name.ends_with("over_voltage_mv"));
    let greatest_v = greatest_mv
        .map(|limit| limit.max as f64 / 1000.0)
        .fold(0.0, f64::max);
    divider(
        design,
        "V_SENSE",
        design.supply_divider(),
        Some(greatest_v),
        findings,
    );
    divider(design, "LEG_A", design.leg_a_divider(), None, findings);
    divider(design, "LEG_B", design.leg_b_divider(), None, findings);
    let legs = (
        design.leg_a_divider().ratio(),
        design.leg_b_divider().ratio(),
    );
    findings.expect(Rule::Ranges, legs.0 == legs.1, || {
        format!("the dividers of the legs differ: {} and {}", legs.0, legs.1)
    });
    floating_motor(design, findings);
}

/// The amplifier saturates before its supply: all limits of a current lie below.
fn currents(design: &Design, findings: &mut Findings) {
    let greatest_ma = design.greatest_current_a() * 1000.0;
    for limit in design.limits.iter().filter(|limit| limit.unit == "mA") {
        for (bound_ma, which) in [(limit.default, "default"), (limit.max, "largest value")] {
            findings.expect(Rule::Ranges, bound_ma as f64 <= greatest_ma, || {
                format!(
                    "U3 reads at most {greatest_ma:.0} mA; the {which} of {} is {bound_ma} mA",
                    limit.name
                )
            });
        }
    }
}

/// A divider's middle stays inside the range of the ADC in operation and below the rating of the
/// pin for a moment; the greatest limit is below its full scale.
fn divider(
    design: &Design,
    net: &str,
    divider: Divider,
    greatest_limit_v: Option<f64>,
    findings: &mut Findings,
) {
    let Some(supply) = design.range("actuator", "VM") else {
        return;
    };
    let ratio = divider.ratio() * (1.0 + divider.error());
    let reference_v = LOGIC_V * (1.0 - design.reference_tolerance());
    findings.expect(Rule::Ranges, supply.high_v * ratio <= reference_v, || {
        format!(
            "{net} reaches {:.2} V; the reference may be {reference_v:.2} V",
            supply.high_v * ratio
        )
    });
    let pin_v = design.figure("STM32F429ZI", "pin_absolute");
    findings.expect(Rule::Ranges, supply.surge_v * ratio <= pin_v, || {
        format!(
            "{net} reaches {:.2} V for a moment; the pin withstands {pin_v} V",
            supply.surge_v * ratio
        )
    });
    // The last code but one is the greatest that is not saturated.
    let codes = design.figure("STM32F429ZI", "adc_codes");
    let full_v = LOGIC_V * (codes - 2.0) / codes / divider.ratio();
    if let Some(limit_v) = greatest_limit_v {
        findings.expect(Rule::Ranges, limit_v <= full_v, || {
            format!("{net} reads at most {full_v:.2} V; a limit may be {limit_v} V")
        });
    }
}

/// With open switches resistors hold the motor at half the supply. The input currents of the
/// amplifier, which have no specified maximum, and the tolerances shift it; at the full rate the
/// lower leg must still be off ground, or the program refuses the scan.
fn floating_motor(design: &Design, findings: &mut Findings) {
    let parallel = |a: f64, b: f64| a * b / (a + b);
    let divider = design.leg_a_divider();
    let sum = divider.upper_ohm + divider.lower_ohm;
    let (up_ohm, down_ohm) = (design.value("R19"), parallel(design.value("R27"), sum));
    let tolerance = divider.tolerance;
    let bias_v = 2.0 * design.amplifier("input_bias") * parallel(up_ohm, down_ohm) / 2.0;
    let share = down_ohm / (up_ohm + down_ohm);
    let spread = share * (1.0 - share) * 2.0 * tolerance;
    let full_rate = design.figure("motor", "full_rate_share");
    for supply_v in ["lowest", "highest"].map(|end| design.figure("battery", end)) {
        let middle_v = supply_v * (share - spread) - bias_v;
        let lower_v = middle_v - full_rate * supply_v / 2.0;
        let ground_v = design.figure("scan", "leg_at_ground");
        findings.expect(Rule::Ranges, lower_v >= ground_v, || {
            format!(
                "with {supply_v} V the lower leg is at {lower_v:.3} V at the full rate; the program refuses less than {ground_v} V"
            )
        });
    }
}
