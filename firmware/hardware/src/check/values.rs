//! Time constants and ratings that follow from the values of the parts.

use super::{Findings, Rule};
use crate::Design;
use crate::design::LOGIC_V;

pub(super) fn check(design: &Design, findings: &mut Findings) {
    time_constants(design, findings);
    braking_energy(design, findings);
    currents(design, findings);
}

/// The filters of what is measured pass what the program samples, and stop what it must not see.
fn time_constants(design: &Design, findings: &mut Findings) {
    let divided = |divider: crate::Divider, capacitor: &str| {
        divider.ratio() * divider.upper_ohm * design.value(capacitor)
    };
    let temperature_ohm = design.value("R24") / 2.0;
    // Legs: 175 us after the switches open they are sampled; the diodes conduct for 122 us of
    // these, and five time constants leave 0.7 %. Supply: the middle of the on time, which follows
    // the edge by 0.4 ms at full duty. Temperature: a control period. Trip: longer than the charge
    // of a gate, 0.2 us; its upper bound is that of the rule for the trip. The threshold is there
    // when the processor starts, some ms after its supply.
    for (name, tau_s, least_s, most_s) in [
        (
            "LEG_A",
            divided(design.leg_a_divider(), "C11"),
            1e-6,
            53e-6 / 5.0,
        ),
        (
            "LEG_B",
            divided(design.leg_b_divider(), "C12"),
            1e-6,
            53e-6 / 5.0,
        ),
        (
            "V_SENSE",
            divided(design.supply_divider(), "C13"),
            10e-6,
            0.4e-3 / 3.0,
        ),
        (
            "T_SENSE",
            temperature_ohm * design.value("C14"),
            50e-6,
            4e-3,
        ),
        (
            "SENSE_F",
            design.value("R13") * design.value("C3"),
            0.2e-6,
            1e-6,
        ),
        (
            "TRIP_REF",
            divided(design.threshold_divider(), "C10"),
            1e-6,
            1e-3,
        ),
    ] {
        let holds = least_s <= tau_s && tau_s <= most_s;
        findings.expect(Rule::Values, holds, || {
            format!("{name}: time constant of {tau_s:.2e} s, not {least_s:.2e} to {most_s:.2e} s")
        });
    }
}

/// The electrolytic capacitor takes the energy of the winding's current, back from a full battery,
/// below the voltage at which the clamp conducts.
fn braking_energy(design: &Design, findings: &mut Findings) {
    let least_f = design.value("C1")
        * (1.0
            - design
                .part("C1")
                .and_then(|part| part.tolerance_pct)
                .unwrap_or(f64::NAN)
                / 100.0);
    let full_v = design.figure("battery", "highest");
    let current_a = design.figure("motor", "reversal_current");
    let energy_2 = design.figure("motor", "inductance") * current_a * current_a;
    let risen_v = (full_v * full_v + energy_2 / least_f).sqrt();
    let clamp = design.part("D1").map_or("", |part| part.kind.as_str());
    let breakdown_v = design.figure(clamp, "breakdown");
    findings.expect(Rule::Values, risen_v <= breakdown_v, || {
        format!("the winding charges C1 to {risen_v:.2} V; D1 conducts from {breakdown_v} V")
    });
}

/// The fuse holds a stalled motor and the processor, and trips before the transistor behind it is
/// overloaded; the shunts bear the current at which the comparator trips.
fn currents(design: &Design, findings: &mut Findings) {
    let holds_a = design.value("F1");
    let needed_a =
        design.figure("motor", "stall_current") + design.figure("battery", "logic_current");
    let transistor = design.part("Q5").map_or("", |part| part.kind.as_str());
    let most_a = design.figure(transistor, "current");
    findings.expect(Rule::Values, needed_a <= holds_a && 2.0 * holds_a <= most_a, || {
        format!("F1 holds {holds_a} A; {needed_a:.2} A are drawn, and Q5 carries {most_a} A, twice that of F1 when it trips")
    });
    let trip_a = design.trip_range_a().1;
    for shunt in ["R1", "R10"] {
        let rating = design
            .part(shunt)
            .map_or("", |part| part.rating.trim_end_matches(" W"));
        let (rated_w, power_w) = (
            rating.parse().unwrap_or(f64::NAN),
            trip_a * trip_a * design.value(shunt),
        );
        findings.expect(Rule::Values, power_w <= rated_w, || {
            format!("{shunt} takes {power_w:.2} W at the trip, and is rated {rated_w} W")
        });
    }
    // A pull-up that the open-drain output can hold at ground: 5 mA.
    let sunk_a = LOGIC_V / design.value("R14");
    findings.expect(Rule::Values, sunk_a <= 5e-3, || {
        format!("R14 takes {sunk_a:.4} A")
    });
}
