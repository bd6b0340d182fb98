//! The winding's current within a control period against its closed form, rule S11 of the referee
//! (`pwm_current.py`): constant back-EMF, slow decay, all switches open at the end of the last of
//! four PWM periods.

use super::*;

const SUPPLY_V: f64 = 6.0;
const OHM: f64 = 7.7;
const HENRY: f64 = 1e-3;
const DIODES_V: f64 = 1.4;

/// Current and its integral after `t` with a constant voltage.
fn step(start_a: f64, volts: f64, t: f64) -> (f64, f64) {
    let (end, tau) = (volts / OHM, HENRY / OHM);
    let left = libm::exp(-t / tau);
    let charge = end * t + (start_a - end) * tau * (1.0 - left);
    (end + (start_a - end) * left, charge)
}

/// Sampled current, mean current and current at the scan, A, in the steady state.
fn referee(duty: f64, back_emf_v: f64) -> [f64; 3] {
    let period = 1e-3;
    let (opens, scan) = (period - 200e-6, period - 25e-6);
    // The on time begins a dead time after the edge, and ends with the compare value; a current
    // against the voltage flows to the supply before and for a dead time after.
    let (dead, fall) = if duty >= 1.0 {
        (0.0, period)
    } else {
        (1e-6, duty * period)
    };
    let sample = (duty * period / 2.0).max(10e-6) + 431.0 / 168e6;
    let sample = sample.min(opens - 10e-6 + 431.0 / 168e6);
    let run = |start_a: f64, from: f64, until: f64| {
        let rise = if start_a < 0.0 { 0.0 } else { dead };
        let rise = f64::clamp(rise, from, until);
        let (at_rise, before) = step(start_a, -back_emf_v, rise - from);
        let fall = f64::clamp(fall, from, until);
        let (at_fall, on) = step(at_rise, SUPPLY_V - back_emf_v, fall - rise);
        let late = if at_fall < 0.0 { dead } else { 0.0 };
        let low = f64::clamp(fall + late, from, until);
        let (at_low, dying) = step(at_fall, SUPPLY_V - back_emf_v, low - fall);
        let (end, after) = step(at_low, -back_emf_v, until - low);
        (end, before + on + dying + after)
    };
    let (mut current, mut seen) = (0.0, [0.0; 3]);
    for _ in 0..20 {
        let mut charge = 0.0;
        for _ in 0..3 {
            let (end, q) = run(current, 0.0, period);
            (current, charge) = (end, charge + q);
        }
        seen[0] = run(current, 0.0, sample).0;
        let (at_window, q) = run(current, 0.0, opens);
        charge += q;
        let against_v = -(SUPPLY_V + DIODES_V) * at_window.signum() - back_emf_v;
        let steady = against_v / OHM;
        let zero = HENRY / OHM * libm::log((at_window - steady) / -steady);
        seen[2] = if zero > scan - opens {
            step(at_window, against_v, scan - opens).0
        } else {
            0.0
        };
        charge += step(at_window, against_v, zero.min(period - opens)).1;
        current = if zero > period - opens {
            step(at_window, against_v, period - opens).0
        } else {
            0.0
        };
        seen[1] = charge / (4.0 * period);
    }
    seen
}

/// The plant with a rotor so heavy that its rate, and with it the back-EMF, stays constant.
fn turning(back_emf_v: f64) -> BoardPlant {
    let mut options = BoardPlantOptions::default();
    options.drivetrain.gear_train.motor_inertia_kg_m2 = 1e-3;
    let mut plant = BoardPlant::try_new(&options).unwrap();
    plant.drivetrain.spin(back_emf_v);
    plant
}

#[test]
fn sampled_mean_and_residual_current_are_those_of_the_closed_form() {
    for back_emf_v in [0.0, 1.0, 3.0, -3.0] {
        for percent in [1, 2, 5, 10, 20, 30, 50, 80, 90, 100] {
            let duty = f64::from(percent) / 100.0;
            let mut plant = turning(back_emf_v);
            plant.defects.is_jammed = back_emf_v == 0.0;
            let bridge = Bridge::driven(560 * percent);
            let (mut charge, mut seen) = (0.0, [0.0; 3]);
            for period in 0..24 {
                for slot in Slot::ALL {
                    let is_window = period % 4 == 3 && matches!(slot, Slot::Legs | Slot::Edge);
                    let state = if is_window { Bridge::Coast } else { bridge };
                    let mean_a = plant.advance(state, slot, bridge.current_instant());
                    if period >= 20 {
                        let (from, until) = slot.cycles(bridge.current_instant());
                        charge += mean_a * slot::seconds(until - from);
                    }
                    match slot {
                        Slot::Current => seen[0] = plant.motor_current_a(),
                        Slot::Legs => seen[2] = plant.motor_current_a(),
                        _ => {}
                    }
                }
            }
            seen[1] = charge / 4e-3;
            let expected = referee(duty, plant.reading().back_emf_v);
            for (seen, expected) in seen.iter().zip(expected) {
                // The back-EMF changes by less than 1 mV in 24 ms: 0.2 mA.
                assert!(
                    (seen - expected).abs() < 0.5e-3,
                    "{percent} %, {back_emf_v} V: {seen} A, closed form {expected} A"
                );
            }
        }
    }
}

#[test]
fn the_closed_form_is_that_of_the_referee() {
    // Means that `pwm_current.steady(duty, 0.0, opens=0.8e-3)` gives, mA; it has no dead time.
    let table = [
        (0.1, 77.86),
        (0.2, 155.65),
        (0.3, 233.28),
        (0.5, 387.24),
        (0.8, 604.87),
        (1.0, 721.73),
    ];
    for (duty, mean_ma) in table {
        let [_, mean_a, _] = referee(duty + 1e-3, 0.0);
        // The on time is a dead time later in the period: 1 us of 780 mA in 4 ms at the window.
        assert!((mean_a * 1e3 - mean_ma).abs() < 0.2, "{duty}: {mean_a} A");
    }
}
