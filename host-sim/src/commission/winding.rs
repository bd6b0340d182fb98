//! The current of a winding over a control period, from its resistance and its inductance.
//!
//! ```text
//! L di/dt = v - R i - e
//! ```
//!
//! `v` is the supply in the on time and 0 in the off time of each PWM period; in the window at the
//! end of the last update period all switches are open, and diodes carry the current until it is
//! zero. The board samples the current in the last update period, in which it has settled; the
//! mean, which makes the torque, is that of all of them.

use model_core::control::pwm_timer::{
    BACK_EMF_INSTANT, CurrentInstant, PWM_COUNTS, TIMER_CLOCK_HZ, TIMER_DIVIDER, WINDOW_START,
};
use model_core::plant::drivetrain::electrical::ElectricalParameters;
use model_core::sensors::dividers::LEG_SETTLING_S;
use model_core::time::UPDATE_PERIODS_PER_CONTROL_PERIOD;

/// Length of a PWM period, s.
const PERIOD_S: f64 = PWM_COUNTS as f64 * COUNT_S;

/// A count of the timer, s.
const COUNT_S: f64 = TIMER_DIVIDER as f64 / TIMER_CLOCK_HZ as f64;

/// Dead time of the bridge at each edge, s.
const DEAD_S: f64 = 1e-6;

/// Forward voltage of the two diodes that conduct in the window, V.
const DIODES_V: f64 = 2.0 * ElectricalParameters::DEFAULT.diode_drop_v;

/// A winding.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Winding {
    /// Resistance of winding, brushes and bridge, ohm.
    pub resistance_ohm: f64,
    /// Inductance, H.
    pub inductance_h: f64,
}

/// What drives a winding over a control period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Driven {
    /// Compare value of the bridge.
    pub compare: i32,
    /// Supply voltage, V.
    pub supply_v: f64,
    /// Back-EMF, V.
    pub back_emf_v: f64,
}

/// Its current.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Current {
    /// At the instant of the sample, A.
    pub sampled_a: f64,
    /// The mean over the control period, A.
    pub mean_a: f64,
    /// How long diodes carry it after the switches have opened, s.
    pub decay_s: f64,
}

impl Current {
    /// Whether the legs have settled before their scan, which shows the back-EMF only then.
    pub fn shows_back_emf(self) -> bool {
        self.decay_s < LONGEST_DECAY_S
    }
}

/// Longest decay of the current behind which the legs settle before their scan, s: eight time
/// constants of them.
const LONGEST_DECAY_S: f64 =
    (BACK_EMF_INSTANT - WINDOW_START) as f64 * COUNT_S - 8.0 * LEG_SETTLING_S;

impl Winding {
    /// The current of a control period.
    pub fn current(&self, driven: Driven) -> Current {
        let Driven {
            compare,
            supply_v,
            back_emf_v,
        } = driven;
        let sign = f64::from(compare.signum());
        let counts = compare.unsigned_abs();
        let is_full = counts >= PWM_COUNTS as u32;
        let dead_s = if is_full { 0.0 } else { DEAD_S };
        let on_s = (f64::from(counts) * COUNT_S - dead_s).max(0.0);
        let instant = CurrentInstant::of_on_time(counts);
        let sample_s = f64::from(instant.sampled_cycles()) / f64::from(TIMER_CLOCK_HZ);
        let window_s = f64::from(WINDOW_START) * COUNT_S;
        let edges = [dead_s, dead_s + on_s, 2.0 * dead_s + on_s, PERIOD_S];
        let driven_v = sign * supply_v;
        // In a dead time a diode carries the current: to the supply if it flows against the drive.
        let voltage_v = |part: usize, now_a: f64| match part {
            0 | 2 if now_a * sign < 0.0 => driven_v,
            1 => driven_v,
            _ => 0.0,
        };
        // From the start of a PWM period to an instant in it: the current there, and its integral.
        let until = |start_a: f64, end_s: f64| {
            let (mut now_s, mut now_a, mut sum) = (0.0_f64, start_a, 0.0);
            for (part, edge_s) in edges.into_iter().enumerate() {
                let next_s = edge_s.min(end_s).max(now_s);
                let over_v = voltage_v(part, now_a) - back_emf_v;
                let (end_a, charge) = self.advance(now_a, over_v, next_s - now_s);
                (now_s, now_a, sum) = (next_s, end_a, sum + charge);
            }
            (now_a, sum)
        };
        // The window before has ended at no current.
        let (mut start_a, mut sum) = (0.0, 0.0);
        for _ in 1..UPDATE_PERIODS_PER_CONTROL_PERIOD {
            let (end_a, part) = until(start_a, PERIOD_S);
            (start_a, sum) = (end_a, sum + part);
        }
        let (opened_a, part) = until(start_a, window_s);
        let most_s = PERIOD_S - window_s;
        let (decay_s, decayed) = self.decay(opened_a, supply_v, back_emf_v, most_s);
        sum += part + decayed;
        Current {
            sampled_a: until(start_a, sample_s).0,
            mean_a: sum / (PERIOD_S * f64::from(UPDATE_PERIODS_PER_CONTROL_PERIOD)),
            decay_s,
        }
    }

    /// The current after a time with this voltage at resistance and inductance, and its integral.
    fn advance(&self, start_a: f64, voltage_v: f64, time_s: f64) -> (f64, f64) {
        let constant_s = self.inductance_h / self.resistance_ohm;
        let steady_a = voltage_v / self.resistance_ohm;
        let gone = -(-time_s / constant_s).exp_m1();
        let end_a = start_a + (steady_a - start_a) * gone;
        let sum = steady_a * time_s + (start_a - steady_a) * constant_s * gone;
        (end_a, sum)
    }

    /// How long the diodes carry this current after the switches have opened, within a time, and
    /// its integral.
    fn decay(&self, start_a: f64, supply_v: f64, back_emf_v: f64, most_s: f64) -> (f64, f64) {
        let against_v = -(supply_v + DIODES_V) * start_a.signum() - back_emf_v;
        let steady_a = against_v / self.resistance_ohm;
        if steady_a * start_a >= 0.0 {
            return (0.0, 0.0);
        }
        let constant_s = self.inductance_h / self.resistance_ohm;
        let zero_s = constant_s * (-start_a / steady_a).ln_1p();
        let decay_s = zero_s.min(most_s);
        (decay_s, self.advance(start_a, against_v, decay_s).1)
    }
}

#[cfg(test)]
mod tests {
    use firmware::measure::current_ma;
    use model_core::plant::board::{BoardPlant, BoardPlantOptions, Bridge, Slot};

    use super::*;

    /// What the board samples of a shaft that is held, mA, and the mean over the control period.
    fn held(compare: i32) -> (f64, f64) {
        let mut plant = BoardPlant::try_new(&BoardPlantOptions::default()).expect("a plant");
        plant.defects.is_jammed = true;
        let driven = Bridge::driven(compare);
        let instant = driven.current_instant();
        let mut mean_ma = 0.0;
        for period in (0..UPDATE_PERIODS_PER_CONTROL_PERIOD).cycle().take(8) {
            let has_window = period + 1 == UPDATE_PERIODS_PER_CONTROL_PERIOD;
            if period == 0 {
                mean_ma = 0.0;
            }
            let mut bridge = driven;
            for slot in Slot::ALL {
                if has_window && slot == Slot::Legs {
                    bridge = Bridge::Coast;
                }
                let slot_ma = plant.advance(bridge, slot, instant) * 1e3;
                mean_ma += slot_ma * slot.length_ns(instant) as f64 / 4e6;
            }
        }
        (f64::from(current_ma(plant.sensed().current)), mean_ma)
    }

    #[test]
    fn sample_and_mean_are_those_of_the_simulated_winding() {
        let winding = Winding {
            resistance_ohm: 7.7,
            inductance_h: 1e-3,
        };
        for compare in [0, 3_000, -6_000, 20_000, -30_000, 45_000, -56_000, 56_000] {
            let (sampled_ma, mean_ma) = held(compare);
            let found = winding.current(Driven {
                compare,
                supply_v: 6.0,
                back_emf_v: 0.0,
            });
            // Half a code of 1.6 mA, and its rounding to a mA.
            let error_ma = (found.sampled_a * 1e3 - sampled_ma).abs();
            assert!(error_ma < 1.4, "{compare}: {found:?}, {sampled_ma} mA");
            // The slots end at whole cycles: 6 ns of 4 ms.
            let error_ma = (found.mean_a * 1e3 - mean_ma).abs();
            assert!(error_ma < 0.1, "{compare}: {found:?}, {mean_ma} mA");
        }
    }
}
