//! Straight lines between breakpoints.

use super::{product, saturated};
use crate::control::units::{ANGLE_END, Angle, angle};
use crate::parameter::ParameterError;
use crate::time::ticks;
use core::num::NonZeroU64;

/// Maximum number of breakpoints of a ramp.
pub const MOST_POINTS: usize = 8;

crate::parameters! {
    /// Up, hold, down through zero to the opposite level, hold, and back.
    pub struct RampParameters {
        /// Level of the first hold; the second has the opposite sign.
        amplitude_deg [""]: 90.0, "deg", -32768.0, 32767.0, "half the way to the hard stop; the paper prints none";
        /// Slope.
        rate_deg_s [""]: 60.0, "deg/s", 1e-3, 1e6, "a quarter of the slower rate limit; the paper prints none";
        /// Hold time at the start and at both levels; twice as long at the end.
        hold_s [""]: 0.5, "s", 0.0, 1e6, "the actuator settles in it; the paper prints none";
    }
}

/// A straight line, valid until the next one starts.
///
/// The error of the slope is at most 2^-47 deg per tick, that of the line 1e-8 deg after a minute.
/// Each line starts exactly at its breakpoint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Line {
    start_tick: u64,
    start: Angle,
    /// In units of 2^-47 deg per tick.
    slope: i64,
}

impl Line {
    const fn between(from: (u64, Angle), to: (u64, Angle)) -> Self {
        let (start, end) = (from.1.limited(ANGLE_END), to.1.limited(ANGLE_END));
        // Two levels are at most 2^16 deg apart: 2^63 units.
        let rise = start.to_bits().abs_diff(end.to_bits()) << 15;
        let slope = match NonZeroU64::new(to.0.saturating_sub(from.0)) {
            // At most half of 2^63.
            Some(run) if run.get() > 1 => (rise / run.get()) as i64,
            // Only the start of so short a line is evaluated.
            _ => 0,
        };
        let slope = if end.to_bits() < start.to_bits() {
            -slope
        } else {
            slope
        };
        Self {
            start_tick: from.0,
            start,
            slope,
        }
    }

    fn at(&self, tick: u64) -> Angle {
        // At most 2^63 * 2^63 in magnitude: adding half a unit and the start does not exceed 127
        // bits.
        let since = tick.saturating_sub(self.start_tick);
        let change = product(self.slope, since.min(i64::MAX as u64) as i64);
        saturated(i128::from(self.start.to_bits()) + ((change + (1 << 14)) >> 15))
    }
}

/// Straight lines between breakpoints; constant before the first and after the last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Ramp {
    lines: [Line; MOST_POINTS],
}

impl Ramp {
    /// Lines through one to [`MOST_POINTS`] breakpoints, in the order of their ticks, limited to
    /// [`ANGLE_END`]. If two have the same tick, the later one applies from that tick.
    ///
    /// ```
    /// use model_core::{control::units::angle, excitation::ramp::Ramp};
    /// const UP: Ramp = Ramp::through(&[(100, angle(-1.0)), (104, angle(1.0))]);
    /// let commands = [0, 101, 102, 900].map(|i| UP.command(i).to_f64());
    /// assert_eq!(commands, [-1.0, -0.5, 0.0, 1.0]);
    /// ```
    pub const fn through<const N: usize>(points: &[(u64, Angle); N]) -> Self {
        const { assert!(N >= 1 && N <= MOST_POINTS) }
        let last = points[N - 1];
        let mut lines = [Line::between(last, last); MOST_POINTS];
        let mut k = 0;
        while k + 1 < N {
            lines[k] = Line::between(points[k], points[k + 1]);
            k += 1;
        }
        Self { lines }
    }

    /// Up, hold, down through zero to the opposite level, hold, and back.
    ///
    /// ```
    /// use model_core::excitation::ramp::{Ramp, RampParameters};
    /// let ramp = Ramp::try_new(&RampParameters::default()).unwrap();
    /// assert_eq!([25_000, 45_000, 80_000].map(|i| ramp.command(i).to_int()), [45, 90, 0]);
    /// ```
    ///
    /// # Errors
    /// [`ParameterError::OutOfRange`] of the first parameter that is NaN or outside its range.
    pub fn try_new(parameters: &RampParameters) -> Result<Self, ParameterError> {
        parameters.check()?;
        let RampParameters {
            amplitude_deg,
            rate_deg_s,
            hold_s,
        } = *parameters;
        let level = angle(amplitude_deg);
        let rise_s = libm::fabs(amplitude_deg) / rate_deg_s;
        let bend = |holds: f64, rises: f64| ticks(holds * hold_s + rises * rise_s);
        Ok(Self::through(&[
            (0, Angle::ZERO),
            (bend(1.0, 0.0), Angle::ZERO),
            (bend(1.0, 1.0), level),
            (bend(2.0, 1.0), level),
            (bend(2.0, 3.0), level.saturating_neg()),
            (bend(3.0, 3.0), level.saturating_neg()),
            (bend(3.0, 4.0), Angle::ZERO),
            (bend(5.0, 4.0), Angle::ZERO),
        ]))
    }

    /// The command at a tick.
    pub fn command(&self, tick: u64) -> Angle {
        let [first, ..] = &self.lines;
        let started = self.lines.iter().rev().find(|l| l.start_tick <= tick);
        started.unwrap_or(first).at(tick)
    }

    /// Tick of the last breakpoint.
    pub fn duration_ticks(&self) -> u64 {
        let [.., last] = &self.lines;
        last.start_tick
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn an_infinitely_steep_ramp_is_a_step() {
        let steep = RampParameters {
            amplitude_deg: 1.0,
            rate_deg_s: 1e6,
            hold_s: 1.0,
        };
        let ramp = Ramp::try_new(&steep).unwrap();
        let commands = [19_999, 20_000, 40_000].map(|tick| ramp.command(tick).to_int());
        assert_eq!(commands, [0, 1, -1]);
    }

    proptest! {
        #[test]
        fn a_line_passes_through_both_ends_and_stays_between_them(
            run in 1_u64..1 << 31, from: i32, to: i32, share in 0.0..1.0
        ) {
            let [a, b] = [from, to].map(|bits| Angle::from_bits(i64::from(bits) << 16));
            let ramp = Ramp::through(&[(7, a), (7 + run, b)]);
            prop_assert_eq!((ramp.command(0), ramp.command(7)), (a, a));
            prop_assert_eq!((ramp.command(7 + run), ramp.command(u64::MAX)), (b, b));
            let within = (share * run as f64) as u64;
            let rise = f64::from(to) - f64::from(from);
            let exact = f64::from(from) + rise * within as f64 / run as f64;
            let bits = ramp.command(7 + within).to_bits() as f64 / 65536.0;
            // 2^31 ticks with a slope error of 2^-47 deg per tick, in units of 2^-16 deg.
            prop_assert!((bits - exact).abs() <= 1.001, "{} {}", bits, exact);
        }
    }
}
