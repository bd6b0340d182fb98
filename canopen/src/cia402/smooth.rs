//! Jerk-limited profiles: the mean of the last demands of a trapezoidal one.
//!
//! A mean over the time `T` changes an acceleration step `a` into a ramp of the acceleration with
//! the jerk `a/T`. It keeps the limits of velocity and acceleration, cannot overshoot, and ends `T`
//! after the trapezoidal profile.

use super::ramp::{UNIT, divide};
use super::{Limits, Parameters, Ramp};

/// A position in whole units. A type of its own, whose arrays are compared one by one: those of
/// integers are compared by `memcmp`, which takes 31 instructions a word on a Cortex-M4.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Place(i32);

/// The trapezoidal profile and its last positions, rounded to whole units.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SmoothProfile<const PERIOD_US: u32> {
    profile: Ramp<PERIOD_US>,
    last: [Place; Parameters::MOST_SMOOTHING as usize],
    /// The sum of those that are in the mean.
    sum: i64,
    /// Demands of the mean, and the position of the oldest.
    count: u8,
    oldest: u8,
    /// Control periods in succession in which the profile was at its target, at most `count`: then
    /// all demands of the mean are the same.
    at_target: u8,
    /// The mean that was returned last.
    mean: Ramp<PERIOD_US>,
}

impl<const PERIOD_US: u32> SmoothProfile<PERIOD_US> {
    /// Of no motion.
    const NONE: Self = Self {
        profile: Ramp::at(0),
        last: [Place(0); Parameters::MOST_SMOOTHING as usize],
        sum: 0,
        count: 0,
        oldest: 0,
        at_target: 0,
        mean: Ramp::at(0),
    };

    /// Continues a motion at its present velocity.
    fn restart(&mut self, motion: Ramp<PERIOD_US>, count: u8) {
        let step = motion.fine_step();
        // The mean lags behind the profile by half of its periods.
        let newest = motion.fine_position() + step * i64::from(count - 1) / 2;
        self.profile = motion.at_fine(newest);
        // In units of 2^-16, with half a unit to round: one division for all.
        let step = divide(step << 16, UNIT as u32);
        let mut place = i64::from(self.profile.position()) << 16 | 1 << 15;
        place -= step * i64::from(count - 1);
        self.sum = 0;
        for place_then in self.last.iter_mut().take(usize::from(count)) {
            *place_then = Place((place >> 16) as i32);
            self.sum += i64::from(place_then.0);
            place += step;
        }
        self.count = count;
        self.oldest = 0;
        self.at_target = if motion.is_stationary() { count - 1 } else { 0 };
    }

    /// Advances a motion one period toward a position, as [`Ramp::to_position`] does; returns
    /// whether it is reached. A motion that something else has moved meanwhile goes on from there.
    ///
    /// Not inlined: a trapezoidal profile does not pay for it.
    #[inline(never)]
    pub fn advance(
        smooth: &mut Option<Self>,
        motion: &mut Ramp<PERIOD_US>,
        (target, count): (i32, u8),
        limits: &Limits,
    ) -> bool {
        let count = count.clamp(1, Parameters::MOST_SMOOTHING);
        // In place: a copy takes longer than the mean.
        let next = smooth.get_or_insert(Self::NONE);
        if next.mean != *motion || next.count != count {
            next.restart(*motion, count);
        }
        let is_reached = next.profile.to_position(target, limits);
        next.at_target = if is_reached {
            (next.at_target + 1).min(count)
        } else {
            0
        };
        let place = next.profile.position();
        if let Some(oldest) = next.last.get_mut(usize::from(next.oldest)) {
            next.sum += i64::from(place) - i64::from(oldest.0);
            *oldest = Place(place);
        }
        next.oldest = if next.oldest + 1 < count {
            next.oldest + 1
        } else {
            0
        };
        // Below 16 times 2^31 times 10^6.
        let mean = divide(next.sum * UNIT, u32::from(count));
        motion.follow(mean);
        next.mean = *motion;
        next.at_target == count
    }
}
