//! Several motors at once, bit for bit those of [`FirstOrder`].
//!
//! Each quantity is an array with one element a motor, and each operation a loop over them without
//! branches, of which the compiler makes vectors. Where a hard stop may act within a period, that
//! motor alone is computed by [`FirstOrder`].

use core::array::from_fn;

use super::{FirstOrder, Motion, Response, motion::TIMES_S, reach_deg};
use crate::plant::{PERIOD, PlantState, Pwm};

/// Rate above which the angle grows from tick to tick whatever is rounded: by 5e-8 deg at least,
/// where the greatest angle, 32,000 deg, is rounded to 4e-12 deg.
const MOVING_DEG_S: f64 = 1e-3;

/// Motors that are driven by the mean voltage and have no rate limits.
#[derive(Debug, Clone)]
pub struct MotorLanes<const N: usize> {
    motors: [FirstOrder; N],
    tau_s: [f64; N],
    /// `D` after the last but one tick of a period, and after the last.
    decay_19: [f64; N],
    decay_20: [f64; N],
    gain_up: [f64; N],
    gain_down: [f64; N],
    limit_deg: [f64; N],
    drive: Drive<N>,
    start: States<N>,
    end: States<N>,
}

/// Angles and rates.
#[derive(Debug, Clone, Copy)]
pub struct States<const N: usize> {
    /// Angle of the output shaft, deg.
    pub angle_deg: [f64; N],
    /// Rate of the output shaft, deg/s.
    pub rate_deg_s: [f64; N],
}

/// What the duty in force does.
#[derive(Debug, Clone, Copy)]
struct Drive<const N: usize> {
    duty_pct: [f64; N],
    target_deg_s: [f64; N],
    /// The state at tick 20 after rest at zero.
    forced: States<N>,
}

/// Least and greatest angle and rate.
#[derive(Debug, Clone, Copy)]
pub struct Extremes<const N: usize> {
    /// Least angle and rate.
    pub least: States<N>,
    /// Greatest angle and rate.
    pub greatest: States<N>,
}

impl<const N: usize> Default for Extremes<N> {
    fn default() -> Self {
        let all = |value| States {
            angle_deg: [value; N],
            rate_deg_s: [value; N],
        };
        Self {
            least: all(f64::INFINITY),
            greatest: all(f64::NEG_INFINITY),
        }
    }
}

#[inline(always)]
fn lesser(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[inline(always)]
fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

impl<const N: usize> Extremes<N> {
    /// Includes the states of all motors.
    #[inline(always)]
    fn see_all(&mut self, states: &States<N>) {
        for lane in 0..N {
            self.see_rate(lane, states.rate_deg_s[lane]);
            self.see_angle(lane, states.angle_deg[lane]);
        }
    }

    #[inline(always)]
    fn see_angle(&mut self, lane: usize, angle_deg: f64) {
        let (least, greatest) = (&mut self.least.angle_deg, &mut self.greatest.angle_deg);
        least[lane] = lesser(angle_deg, least[lane]);
        greatest[lane] = greater(angle_deg, greatest[lane]);
    }

    #[inline(always)]
    fn see_rate(&mut self, lane: usize, rate_deg_s: f64) {
        let (least, greatest) = (&mut self.least.rate_deg_s, &mut self.greatest.rate_deg_s);
        least[lane] = lesser(rate_deg_s, least[lane]);
        greatest[lane] = greater(rate_deg_s, greatest[lane]);
    }
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
        let rest = States {
            angle_deg: [0.0; N],
            rate_deg_s: [0.0; N],
        };
        let mut lanes = Self {
            tau_s: from_fn(|lane| motors[lane].lag.tau_s),
            decay_19: from_fn(|lane| motors[lane].lag.decay[PERIOD - 1]),
            decay_20: from_fn(|lane| motors[lane].lag.decay[PERIOD]),
            gain_up: from_fn(|lane| motors[lane].parameters.motor_gain_up),
            gain_down: from_fn(|lane| motors[lane].parameters.motor_gain_down),
            limit_deg: from_fn(|lane| motors[lane].parameters.position_limit_deg),
            drive: Drive {
                duty_pct: [0.0; N],
                target_deg_s: [0.0; N],
                forced: rest,
            },
            start: rest,
            end: rest,
            motors,
        };
        lanes.set_duty(&[0.0; N]);
        Some(lanes)
    }

    /// The states at the start of the next period.
    pub fn states(&self) -> &States<N> {
        &self.end
    }

    /// Drives by these duties, within +-100 %, from the next period on.
    #[inline(always)]
    pub fn set_duty(&mut self, duty_pct: &[f64; N]) {
        for lane in 0..N {
            let duty = duty_pct[lane];
            let gain = if duty > 0.0 {
                self.gain_up[lane]
            } else {
                self.gain_down[lane]
            };
            let target = gain * duty;
            let driven = Motion {
                start: PlantState::default(),
                target_deg_s: target,
            };
            let forced = driven.after(TIMES_S[PERIOD], self.decay_20[lane], self.tau_s[lane]);
            self.drive.target_deg_s[lane] = target;
            self.drive.forced.angle_deg[lane] = forced.angle_deg;
            self.drive.forced.rate_deg_s[lane] = forced.rate_deg_s;
            self.drive.duty_pct[lane] = duty;
        }
    }

    /// Passes a period, of which the first tick is seen.
    #[inline(always)]
    pub fn pass(&mut self, seen: &mut Extremes<N>) {
        let start = self.end;
        seen.see_all(&start);
        let (mut end, mut stops, mut is_any) = (start, [0_i64; N], 0);
        for lane in 0..N {
            let (state, is_free) = self.free_end(lane, &start);
            end.angle_deg[lane] = state.angle_deg;
            end.rate_deg_s[lane] = state.rate_deg_s;
            stops[lane] = i64::from(!is_free);
            is_any |= stops[lane];
        }
        (self.start, self.end) = (start, end);
        if is_any != 0 {
            self.stop(&stops);
        }
    }

    /// Passes a period, of which so many ticks are seen, from 1 to 20.
    ///
    /// The rate runs monotonically towards its target, so that it is least and greatest at the
    /// first or the last tick, and so is the angle where the motor does not reverse. Every tick is
    /// computed where it does, unless what is seen already reaches further.
    #[inline(always)]
    pub fn pass_seeing_ticks(&mut self, ticks: usize, seen: &mut Extremes<N>) {
        let start = self.end;
        seen.see_all(&start);
        let (mut end, mut stops, mut is_any) = (start, [0_i64; N], 0);
        let (mut unclear, mut is_any_unclear) = ([0_i64; N], i64::from(ticks < PERIOD));
        for lane in 0..N {
            let (state, is_free) = self.free_end(lane, &start);
            end.angle_deg[lane] = state.angle_deg;
            end.rate_deg_s[lane] = state.rate_deg_s;
            stops[lane] = i64::from(!is_free);
            is_any |= stops[lane];
            let (angle, rate) = (start.angle_deg[lane], start.rate_deg_s[lane]);
            let target = self.drive.target_deg_s[lane];
            let (decay, tau) = (self.decay_19[lane], self.tau_s[lane]);
            let last = self
                .motion(lane, &start)
                .after(TIMES_S[PERIOD - 1], decay, tau);
            let is_moving = (rate > MOVING_DEG_S) & (last.rate_deg_s > MOVING_DEG_S)
                | (rate < -MOVING_DEG_S) & (last.rate_deg_s < -MOVING_DEG_S);
            let reach = reach_deg(rate, target);
            let is_within = (angle - reach >= seen.least.angle_deg[lane])
                & (angle + reach <= seen.greatest.angle_deg[lane]);
            let is_clear = is_free & (is_moving | is_within) & (ticks == PERIOD);
            unclear[lane] = i64::from(!is_clear);
            is_any_unclear |= unclear[lane];
            // What is not clear is looked at below, tick by tick.
            seen.see_angle(lane, if is_clear { last.angle_deg } else { angle });
            seen.see_rate(lane, if is_clear { last.rate_deg_s } else { rate });
        }
        (self.start, self.end) = (start, end);
        if is_any_unclear != 0 {
            self.see_each_tick(&unclear, &stops, ticks, seen);
        }
        if is_any != 0 {
            self.stop(&stops);
        }
    }

    /// The motion that starts in one of these states.
    #[inline(always)]
    fn motion(&self, lane: usize, start: &States<N>) -> Motion {
        let driven = Motion {
            start: PlantState::default(),
            target_deg_s: self.drive.target_deg_s[lane],
        };
        driven.plus(start.of(lane))
    }

    /// The state after a period in which no stop acts, and whether none does.
    #[inline(always)]
    fn free_end(&self, lane: usize, start: &States<N>) -> (PlantState, bool) {
        let (angle, rate) = (start.angle_deg[lane], start.rate_deg_s[lane]);
        let lost_deg_s = rate * self.decay_20[lane];
        let coasted_deg = self.tau_s[lane] * lost_deg_s;
        let end = PlantState {
            angle_deg: angle - coasted_deg + self.drive.forced.angle_deg[lane],
            rate_deg_s: rate + lost_deg_s + self.drive.forced.rate_deg_s[lane],
        };
        let reach = reach_deg(rate, self.drive.target_deg_s[lane]);
        (end, angle.abs() + reach < self.limit_deg[lane])
    }

    /// Sees the first ticks of the period that has just been passed, of some of the motors.
    #[cold]
    fn see_each_tick(
        &self,
        chosen: &[i64; N],
        stops: &[i64; N],
        ticks: usize,
        seen: &mut Extremes<N>,
    ) {
        for lane in (0..N).filter(|lane| chosen[*lane] != 0) {
            if stops[lane] != 0 {
                for state in &self.stepped(lane)[..ticks] {
                    seen.see_angle(lane, state.angle_deg);
                    seen.see_rate(lane, state.rate_deg_s);
                }
                continue;
            }
            let states = self.motors[lane].lag.ticks(&self.motion(lane, &self.start));
            for (angle, rate) in states.angle_deg.iter().zip(&states.rate_deg_s).take(ticks) {
                seen.see_angle(lane, *angle);
                seen.see_rate(lane, *rate);
            }
        }
    }

    /// Ends the period at the stops of some of the motors.
    #[cold]
    fn stop(&mut self, stops: &[i64; N]) {
        for lane in (0..N).filter(|lane| stops[*lane] != 0) {
            let end = self.stepped(lane)[PERIOD];
            self.end.angle_deg[lane] = end.angle_deg;
            self.end.rate_deg_s[lane] = end.rate_deg_s;
        }
    }

    /// The period that has just been passed, tick by tick.
    fn stepped(&self, lane: usize) -> [PlantState; PERIOD + 1] {
        let motor = &self.motors[lane];
        let response = Response::new(
            &motor.parameters,
            &motor.lag,
            motor.pwm,
            self.drive.duty_pct[lane],
        );
        motor.stepped(&response, self.start.of(lane))
    }

    /// The state of a motor at a tick of the period that was passed last, from 0 to 19.
    pub fn at(&self, lane: usize, tick: usize) -> PlantState {
        let start = self.start.of(lane);
        match tick {
            0 => start,
            tick if self.free_end(lane, &self.start).1 => {
                let lag = &self.motors[lane].lag;
                lag.at(&self.motion(lane, &self.start), tick)
            }
            tick => self.stepped(lane)[tick],
        }
    }
}

impl<const N: usize> States<N> {
    /// The state of one motor.
    #[inline(always)]
    pub fn of(&self, lane: usize) -> PlantState {
        PlantState {
            angle_deg: self.angle_deg[lane],
            rate_deg_s: self.rate_deg_s[lane],
        }
    }
}
