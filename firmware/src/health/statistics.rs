//! Standard error of a mean to which each motion gives a value.
//!
//! The difference of two values in succession, of the same way, has twice the variance `s^2` of
//! one, and no slow change is in it. A mean over `n` control periods in motions of about the same
//! length `T` has
//!
//! ```text
//! variance = s^2 T/n = mean(difference^2 T)/(2 n)
//! ```
//!
//! and half of it where it forgets the first motions: the standard error is then up to 1.4 times
//! too high. Half the sum of both ways has half the variance of one: that of twice the control
//! periods. What is wrong in all motions alike is not in it.

use crate::timing::periods;

/// Control periods of a motion, or of a load, whose value counts, 0.1 s: a shorter one has hardly a
/// weight in the mean.
pub(super) const SHORTEST: u16 = periods(100);

/// Differences of a mean.
const LENGTH: u16 = 32;

/// Differences after which the standard error is known.
const ENOUGH: u16 = 4;

/// Fractional bits of the mean.
const FRACTION: u32 = 8;

/// The greatest difference.
const GREATEST: u32 = u16::MAX as u32;

/// The scatter of single values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Statistics {
    /// The last value of each way.
    last: [Option<i32>; 2],
    differences: u16,
    /// Mean of the squares of the differences, times control periods.
    squares: i64,
}

impl Statistics {
    /// Takes the value of a motion, and its control periods. Not inlined: it runs a few times a
    /// second.
    #[inline(never)]
    pub fn value(&mut self, is_positive: bool, value: i32, periods: u16) {
        let [negative, positive] = &mut self.last;
        let last = if is_positive { positive } else { negative };
        if let Some(last) = last.replace(value) {
            let difference = i64::from(value.abs_diff(last).min(GREATEST));
            let square = difference * difference * i64::from(periods);
            self.differences = self.differences.saturating_add(1).min(LENGTH);
            // The count is not 0.
            let count = i64::from(self.differences).max(1);
            self.squares += ((square << FRACTION) - self.squares) / count;
        }
    }

    /// Standard error of a mean over so many control periods, rounded up; `None` before there are
    /// enough differences.
    #[inline(never)]
    pub fn standard_error(&self, periods: u16) -> Option<i32> {
        let twice = i64::from(periods) << (FRACTION + 1);
        let variance = self.squares.checked_div(twice)?;
        (self.differences >= ENOUGH).then(|| root_above(variance))
    }
}

/// The least integer, at most 2^16, whose square is above a value. The one of the library has a
/// table of 512 bytes.
fn root_above(value: i64) -> i32 {
    let mut root = 0;
    for bit in (0..16).rev() {
        let higher = root | 1 << bit;
        if i64::from(higher) * i64::from(higher) <= value {
            root = higher;
        }
    }
    root + 1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of both ways with their own level, in motions of 100 control periods, whose values are
    /// uniform within `scatter` of the level, which changes by `change` a motion.
    fn of(motions: u16, scatter: i32, change: i32) -> Statistics {
        let mut statistics = Statistics::default();
        let mut random = 7_u32;
        for motion in 0..motions {
            let is_positive = motion % 2 == 0;
            let level = if is_positive { 500 } else { 300 };
            // By xorshift.
            for (left, shift) in [(true, 13), (false, 17), (true, 5)] {
                random ^= if left {
                    random << shift
                } else {
                    random >> shift
                };
            }
            let off = random % (2 * scatter as u32 + 1);
            let value = level + off as i32 - scatter + change * i32::from(motion);
            statistics.value(is_positive, value, 100);
        }
        statistics
    }

    #[test]
    fn the_standard_error_is_that_of_independent_values() {
        // Uniform within +-60: sigma is 60/sqrt(3), and that of the mean of 16 values a quarter of
        // it, 8.7.
        let found = of(200, 60, 0).standard_error(1_600).unwrap();
        // The scatter of 32 squares, about 1/sqrt(32) of the standard error, and 1 of rounding up.
        assert!((7..=11).contains(&found), "{found}");
    }

    #[test]
    fn a_root_is_rounded_up() {
        for (value, root) in [(0, 1), (1, 2), (3, 2), (4, 3), (99, 10), (1 << 32, 1 << 16)] {
            assert_eq!(root_above(value), root);
        }
    }

    #[test]
    fn a_slow_change_is_no_scatter() {
        let [still, changing] = [0, 1].map(|change| of(200, 60, change).standard_error(1_600));
        assert!(still.unwrap().abs_diff(changing.unwrap()) <= 1);
    }

    #[test]
    fn four_differences_are_needed() {
        assert_eq!(of(5, 60, 0).standard_error(500), None);
        assert!(of(6, 60, 0).standard_error(600).is_some());
    }
}
