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
pub(super) struct SmoothProfile {
    profile: Ramp,
    last: [Place; Parameters::MOST_SMOOTHING as usize],
    /// The sum of those that are in the mean.
    sum: i64,
    /// Demands of the mean, and the position of the oldest.
    count: u8,
    oldest: u8,
    /// The mean that was returned last.
    mean: Ramp,
}

impl SmoothProfile {
    /// Continues a motion at its present velocity.
    fn of(motion: Ramp, count: u8, period_us: u32) -> Self {
        let count = count.clamp(1, Parameters::MOST_SMOOTHING);
        let step = motion.fine_step(period_us);
        // The mean lags behind the profile by half of its periods.
        let ahead = step * i64::from(count - 1) / 2;
        let mut last = [Place(0); Parameters::MOST_SMOOTHING as usize];
        let newest = motion.fine_position() + ahead;
        // A step in units of 2^-16: one division for all.
        let (place, step) = (
            i64::from(motion.at_fine(newest).position()),
            divide(step << 16, UNIT as u32),
        );
        let mut sum = 0;
        for (place_then, age) in last.iter_mut().zip((0..i64::from(count)).rev()) {
            *place_then = Place((place - ((age * step) >> 16)) as i32);
            sum += i64::from(place_then.0);
        }
        Self {
            profile: motion.at_fine(newest),
            last,
            sum,
            count,
            oldest: 0,
            mean: motion,
        }
    }

    /// Advances a motion one period toward a position, as [`Ramp::to_position`] does; returns
    /// whether it is reached. A motion that something else has moved meanwhile goes on from there.
    ///
    /// Not inlined: a trapezoidal profile does not pay for it.
    #[inline(never)]
    pub fn advance(
        smooth: &mut Option<Self>,
        motion: &mut Ramp,
        (target, count): (i32, u8),
        limits: &Limits,
        period_us: u32,
    ) -> bool {
        // In place: a copy takes longer than the mean.
        let next = match smooth {
            Some(next) if next.mean == *motion && next.count == count => next,
            _ => smooth.insert(Self::of(*motion, count, period_us)),
        };
        let is_reached = next.profile.to_position(target, limits, period_us);
        let place = next.profile.position();
        if let Some(oldest) = next.last.get_mut(usize::from(next.oldest)) {
            next.sum += i64::from(place) - i64::from(oldest.0);
            *oldest = Place(place);
        }
        next.oldest = if next.oldest + 1 < next.count {
            next.oldest + 1
        } else {
            0
        };
        // Below 16 times 2^31 times 10^6.
        let mean = divide(next.sum * UNIT, u32::from(next.count));
        motion.follow(mean, period_us);
        next.mean = *motion;
        let mut in_use = next.last.iter().take(usize::from(next.count));
        is_reached && in_use.all(|it| *it == Place(place))
    }
}
