//! Means of both ways of the motions: friction, load and constant of the back-EMF.
//!
//! While the shaft turns one way, rate, back-EMF and current have means of their own for that way.
//! In the sum of both ways the offsets and a constant load cancel:
//!
//! ```text
//! friction = (I+ + I-)/2     load = (I+ - I-)/2     constant = (E+ + E-)/(w+ + w-)
//! ```
//!
//! with current and back-EMF in the direction of the motion. The current that accelerates the
//! inertia cancels as well: a motion begins and ends at the least rate, so the mean of its
//! acceleration is zero. Therefore the results are taken where a motion ends. The back-EMF shows
//! where that is, by its mean over the control period whose current is taken. The filtered rate
//! lags by `t`, so between the places where it is the least rate the shaft loses `2 a t` by an
//! acceleration `a`: the friction of a motion of the time `T` would be too low by `J 2 a t/(k T)`.
//!
//! The current is a mean over a PWM period, which does not have the coast window: where that cuts
//! a slow decay, the mean over the control period is greater by `(E/R) (window + L/R)/period`.
//! Therefore a friction is comparable with that of the same motions only.

use super::Mean;
use super::statistics::{SHORTEST, Statistics};
use crate::{
    interface::Telemetry,
    timing::{periods, thousandths},
};

/// Control periods of a mean, 16 s of motion.
pub(super) const LENGTH: u16 = periods(16_384);

/// Control periods in motion, each way, after which the means are reported: 4 s.
const ENOUGH: u16 = periods(4_096);

/// Means while the shaft turns one way, in that direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Way {
    /// Values, at most [`LENGTH`].
    count: u16,
    /// deg/s.
    rate: Mean,
    /// mV.
    back_emf: Mean,
    /// mA.
    current: Mean,
}

impl Way {
    fn take(&mut self, (rate, back_emf, current): (i32, i32, i32)) {
        self.count = self.count.saturating_add(1).min(LENGTH);
        self.rate.take(rate, self.count);
        self.back_emf.take(back_emf, self.count);
        self.current.take(current, self.count);
    }
}

/// Sums of the present motion, in its direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Motion {
    is_positive: bool,
    /// Control periods, at most [`LENGTH`]; the values of later ones are not in the sums.
    periods: u16,
    deg_s: i32,
    mv: i32,
    ma: i32,
}

/// The results of both ways.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Results {
    /// Current against friction, 0.1 mA.
    pub friction: i32,
    /// Current against a load, in the positive direction, 0.1 mA.
    pub load: i32,
    /// Constant of the back-EMF, uV s/deg.
    pub constant: i32,
}

impl Results {
    fn of(positive: &Way, negative: &Way) -> Option<Self> {
        let mv = i64::from(positive.back_emf.0) + i64::from(negative.back_emf.0);
        let deg_s = i64::from(positive.rate.0) + i64::from(negative.rate.0);
        let (ahead, back) = (positive.current.in_tenths(), negative.current.in_tenths());
        Some(Self {
            friction: (ahead + back) / 2,
            load: (ahead - back) / 2,
            constant: (mv * 1000).checked_div(deg_s)? as i32,
        })
    }
}

/// The means, and their results at the end of the last motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Motions {
    positive: Way,
    negative: Way,
    present: Option<Motion>,
    results: Option<Results>,
    friction: Statistics,
    constant: Statistics,
}

impl Motions {
    /// The present motion has no end.
    pub fn interrupt(&mut self) {
        self.present = None;
    }

    /// Takes a control period of an enabled actuator: the mean of its back-EMF, and the one of the
    /// least rate, mV.
    pub fn observe(&mut self, t: &Telemetry, mean_mv: i32, least_mv: i32) {
        if mean_mv.abs() <= least_mv {
            if let Some(motion) = self.present.take() {
                self.end(&motion);
            }
            return;
        }
        let (way, sign) = if mean_mv > 0 {
            (&mut self.positive, 1)
        } else {
            (&mut self.negative, -1)
        };
        let values = (
            sign * thousandths(t.rate) / 1000,
            sign * t.back_emf_mv,
            sign * t.current_ma,
        );
        way.take(values);
        let motion = self.present.get_or_insert_default();
        motion.is_positive = sign > 0;
        if motion.periods < LENGTH {
            motion.periods += 1;
            // Measurements are below 2^16, and the sums below 2^30.
            motion.deg_s += values.0;
            motion.mv += values.1;
            motion.ma += values.2;
        }
    }

    fn end(&mut self, motion: &Motion) {
        if motion.periods >= SHORTEST {
            let (is_positive, periods) = (motion.is_positive, motion.periods);
            let tenths = i64::from(motion.ma) * 10 / i64::from(periods);
            self.friction.value(is_positive, tenths as i32, periods);
            let constant = i64::from(motion.mv) * 1000;
            if let Some(constant) = constant.checked_div(motion.deg_s.into()) {
                self.constant.value(is_positive, constant as i32, periods);
            }
        }
        if self.samples() >= ENOUGH {
            self.results = Results::of(&self.positive, &self.negative);
        }
    }

    /// Control periods of the means, of the way that has fewer.
    pub fn samples(&self) -> u16 {
        self.positive.count.min(self.negative.count)
    }

    /// The results; `None` before there are enough values.
    pub fn results(&self) -> Option<Results> {
        self.results
    }

    /// Standard error of friction and load, 0.1 mA; `None` while it is not known.
    pub fn friction_error(&self) -> Option<i32> {
        self.results?;
        self.friction.standard_error(2 * self.samples())
    }

    /// That of the constant, uV s/deg.
    pub fn constant_error(&self) -> Option<i32> {
        self.results?;
        self.constant.standard_error(2 * self.samples())
    }
}
