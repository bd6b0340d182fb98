//! Several motors at once, bit for bit those of [`FirstOrder`].
//!
//! Each quantity is an array with one element a motor, and each operation a loop over them without
//! branches, of which the compiler makes vectors. A motor that may reach a hard stop within a
//! control period is computed alone, as [`FirstOrder`] computes it.

#![allow(
    clippy::needless_range_loop,
    reason = "each loop is over an index of many arrays"
)]

use core::array::from_fn;

use super::{FirstOrder, Motion, Response, free_end, motion::TIMES_S, reach_deg};
use crate::actuator::{PlantKind, Settings};
use crate::limits::{greater, lesser};
use crate::parameter::ParameterError;
use crate::plant::lanes::{Extremes, PlantLanes, STEPS, States, float, greater_of, lesser_of};
use crate::plant::{PERIOD, PlantState, Pwm};
use crate::time::{CONTROL_PERIOD_TICKS, TICK_S};

/// PWM periods of a control period.
const EDGES: usize = CONTROL_PERIOD_TICKS as usize / PERIOD;

/// Rate above which the angle grows from tick to tick whatever is rounded: by 5e-10 deg at least,
/// where two angles are off by [`ROUNDING_DEG`] at most.
const MOVING_DEG_S: f64 = 1e-5;

/// What two angles of 32,000 deg are off by at most: each sum by half of 7.3e-12 deg, and there are
/// two to an angle.
const ROUNDING_DEG: f64 = 2e-11;

/// Motors that are driven by the mean voltage and have no rate limits.
#[derive(Debug, Clone)]
pub struct MotorLanes<const N: usize> {
    motors: [FirstOrder; N],
    tau_s: [f64; N],
    /// `D` after the last but one tick of a period, and after the last.
    decay_19: [f64; N],
    decay_20: [f64; N],
    /// Steady rate per duty, (deg/s)/%.
    gain_up: [f64; N],
    gain_down: [f64; N],
    limit_deg: [f64; N],
    /// In force during the first PWM period of the last control period, and since then.
    drives: [Drive<N>; 2],
    /// At the start of the last control period, and at its end.
    start: States<N>,
    end: States<N>,
    /// The tick of the last control period that was seen last.
    last_tick: usize,
}

/// What a duty does.
#[derive(Debug, Clone, Copy)]
struct Drive<const N: usize> {
    /// In steps of 2^-32 %.
    duty: [i64; N],
    target_deg_s: [f64; N],
    /// The state at tick 20 after rest at zero.
    forced: States<N>,
}

impl<const N: usize> MotorLanes<N> {
    /// These motors, at rest at zero; `None` if one of them has a rate limit or a bridge that
    /// switches.
    pub fn new(motors: [FirstOrder; N]) -> Option<Self> {
        let is_plain = |motor: &FirstOrder| {
            let p = &motor.parameters;
            motor.pwm == Pwm::Average
                && p.rate_limit_up_deg_s == f64::INFINITY
                && p.rate_limit_down_deg_s == f64::INFINITY
        };
        if !motors.iter().all(is_plain) {
            return None;
        }
        let rest = States::all(0.0);
        let drive = Drive {
            duty: [0; N],
            target_deg_s: [0.0; N],
            forced: rest,
        };
        let mut lanes = Self {
            tau_s: from_fn(|lane| motors[lane].lag.tau_s),
            decay_19: from_fn(|lane| motors[lane].lag.decay[PERIOD - 1]),
            decay_20: from_fn(|lane| motors[lane].lag.decay[PERIOD]),
            gain_up: from_fn(|lane| motors[lane].parameters.motor_gain_up),
            gain_down: from_fn(|lane| motors[lane].parameters.motor_gain_down),
            limit_deg: from_fn(|lane| motors[lane].parameters.position_limit_deg),
            drives: [drive; 2],
            start: rest,
            end: rest,
            last_tick: 0,
            motors,
        };
        lanes.set_duty(&[0; N]);
        Some(lanes)
    }

    /// What these duties, within +-100 %, do: as [`Response::new`].
    #[inline(always)]
    fn set_duty(&mut self, duty: &[i64; N]) {
        let [_, drive] = &mut self.drives;
        for lane in 0..N {
            let gain = if duty[lane] > 0 {
                self.gain_up[lane]
            } else {
                self.gain_down[lane]
            };
            drive.duty[lane] = duty[lane];
            drive.target_deg_s[lane] = gain * (float(duty[lane]) / STEPS);
            let motion = drive.motion(lane);
            let end = motion.after(TIMES_S[PERIOD], self.decay_20[lane], self.tau_s[lane]);
            drive.forced.set(lane, end);
        }
    }

    /// As [`PlantLanes::pass`].
    ///
    /// The rate runs monotonically from target to target, so that it is least and greatest at the
    /// first or the last tick of a PWM period, and so is the angle where the motor does not
    /// reverse. A motor that may reverse further out than it was seen, or reach a stop, is computed
    /// tick by tick.
    #[inline(always)]
    fn run<const ALL: bool>(&mut self, duty: &[i64; N], ticks: usize, seen: &mut Extremes<N>) {
        self.drives[0] = self.drives[1];
        self.set_duty(duty);
        let [first, then] = &self.drives;
        let mut unclear = [0_i64; N];
        let mut is_any_unclear = 0;
        for lane in 0..N {
            let start = self.end.of(lane);
            let (tau_s, decay) = (self.tau_s[lane], self.decay_20[lane]);
            let mut state = start;
            let (mut least, mut greatest) = (state, state);
            // Where the angle certainly stays.
            let (mut low_deg, mut high_deg) = (start.angle_deg, start.angle_deg);
            for edge in 0..EDGES {
                let drive = if edge == 0 { first } else { then };
                if edge > 0 {
                    (least, greatest) = (lesser_of(state, least), greater_of(state, greatest));
                }
                if ALL {
                    // `plus` is part of the sum of a single motor.
                    let motion = drive.motion(lane).plus(state);
                    let last = motion.after(TIMES_S[PERIOD - 1], self.decay_19[lane], tau_s);
                    (least, greatest) = (lesser_of(last, least), greater_of(last, greatest));
                    let [from, to] = [state.rate_deg_s, last.rate_deg_s];
                    let is_moving =
                        (lesser(from, to) > MOVING_DEG_S) | (greater(from, to) < -MOVING_DEG_S);
                    let fastest = greater(from.abs(), to.abs());
                    // At rest nothing is rounded.
                    let rounding_deg = if fastest > 0.0 { ROUNDING_DEG } else { 0.0 };
                    let reach = fastest * (PERIOD as f64 * TICK_S) + rounding_deg;
                    let reach = if is_moving { 0.0 } else { reach };
                    low_deg = lesser(state.angle_deg - reach, low_deg);
                    high_deg = greater(state.angle_deg + reach, high_deg);
                }
                state = free_end(state, decay, tau_s, drive.forced.of(lane));
            }
            // The rate stays below the sum of where it starts and the targets. Until the last PWM
            // period the angle moves by its ticks times that, and there it has to be clear by the
            // criterion of a single motor, 21 ticks of twice the sum. Two more cover the rounding.
            const REACH_S: f64 = ((EDGES + 1) * PERIOD + 4) as f64 * TICK_S;
            let fastest = start.rate_deg_s.abs()
                + first.target_deg_s[lane].abs()
                + then.target_deg_s[lane].abs();
            let reach = fastest * REACH_S;
            let is_free = start.angle_deg.abs() + reach < self.limit_deg[lane];
            // What is not clear is seen below.
            let before = (seen.least.of(lane), seen.greatest.of(lane));
            least = lesser_of(least, before.0);
            greatest = greater_of(greatest, before.1);
            let is_within = (low_deg >= least.angle_deg) & (high_deg <= greatest.angle_deg);
            let is_clear = is_free & is_within & (ticks == EDGES * PERIOD);
            unclear[lane] = i64::from(!is_clear);
            is_any_unclear |= unclear[lane];
            if !is_clear {
                (least, greatest) = before;
            }
            seen.least.set(lane, least);
            seen.greatest.set(lane, greatest);
            self.start.set(lane, start);
            self.end.set(lane, state);
        }
        if is_any_unclear != 0 {
            for lane in 0..N {
                if unclear[lane] != 0 {
                    let end = self.pass_alone(lane, |tick, state| {
                        if tick < ticks && (ALL || tick % PERIOD == 0) {
                            seen.see(lane, state);
                        }
                    });
                    self.end.set(lane, end);
                }
            }
        }
    }

    /// The control period that was just passed for one motor, as [`FirstOrder`] computes it: shows
    /// all ticks and returns the end.
    #[cold]
    fn pass_alone(&self, lane: usize, mut show: impl FnMut(usize, PlantState)) -> PlantState {
        let motor = &self.motors[lane];
        let mut state = self.start.of(lane);
        for edge in 0..EDGES {
            let drive = &self.drives[usize::from(edge > 0)];
            let reach = reach_deg(state.rate_deg_s, drive.target_deg_s[lane]);
            if state.angle_deg.abs() + reach < motor.parameters.position_limit_deg {
                let ticks = motor.lag.ticks(&drive.motion(lane).plus(state));
                show(edge * PERIOD, state);
                for tick in 1..PERIOD {
                    let state = PlantState {
                        angle_deg: ticks.angle_deg[tick],
                        rate_deg_s: ticks.rate_deg_s[tick],
                    };
                    show(edge * PERIOD + tick, state);
                }
                let (decay, tau_s) = (self.decay_20[lane], self.tau_s[lane]);
                state = free_end(state, decay, tau_s, drive.forced.of(lane));
            } else {
                let p = &motor.parameters;
                let duty_pct = float(drive.duty[lane]) / STEPS;
                let response = Response::new(p, &motor.lag, motor.pwm, duty_pct);
                let states = motor.stepped(&response, state);
                for (tick, state) in states[..PERIOD].iter().enumerate() {
                    show(edge * PERIOD + tick, *state);
                }
                state = states[PERIOD];
            }
        }
        state
    }

    /// The state of a motor at a tick of the control period that was passed last, from 0 to 79.
    fn at(&self, lane: usize, tick: usize) -> PlantState {
        let mut found = self.start.of(lane);
        self.pass_alone(lane, |shown, state| {
            if shown == tick {
                found = state;
            }
        });
        found
    }
}

impl<const N: usize> Drive<N> {
    /// The motion from rest at zero.
    #[inline(always)]
    fn motion(&self, lane: usize) -> Motion {
        Motion {
            start: PlantState::default(),
            target_deg_s: self.target_deg_s[lane],
        }
    }
}

impl<const N: usize> PlantLanes<N> for MotorLanes<N> {
    const KIND: PlantKind = PlantKind::FirstOrder;

    fn try_new(settings: [&Settings; N]) -> Result<Option<Self>, ParameterError> {
        for s in settings {
            s.first_order.check()?;
        }
        let motors = settings.map(|s| FirstOrder::of_checked(s.first_order, s.pwm));
        Ok(Self::new(motors))
    }

    fn states(&self) -> &States<N> {
        &self.end
    }

    #[inline(always)]
    fn pass<const ALL: bool>(&mut self, duty: &[i64; N], ticks: usize, seen: &mut Extremes<N>) {
        self.run::<ALL>(duty, ticks, seen);
        self.last_tick = if ALL {
            ticks - 1
        } else {
            (ticks - 1) / PERIOD * PERIOD
        };
    }

    fn last_seen(&self, lane: usize) -> PlantState {
        self.at(lane, self.last_tick)
    }

    fn keep(&mut self, other: &Self, lane: usize) {
        for (drive, other) in self.drives.iter_mut().zip(&other.drives) {
            drive.duty[lane] = other.duty[lane];
            drive.target_deg_s[lane] = other.target_deg_s[lane];
            drive.forced.set(lane, other.forced.of(lane));
        }
        self.start.set(lane, other.start.of(lane));
        self.end.set(lane, other.end.of(lane));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::units::Percent;

    #[test]
    fn a_duty_as_a_number_is_that_of_its_type() {
        for bits in [
            0,
            1,
            -1,
            100 << 32,
            -(100 << 32),
            0x12_3456_789a,
            -0x12_3456_789b,
        ] {
            assert_eq!(float(bits) / STEPS, Percent::from_bits(bits).to_f64());
        }
    }
}
