//! A sum of cosines of equal amplitude at multiples of one frequency.
//!
//! Schroeder phases (IEEE Transactions on Information Theory 16 (1970) 85-89), `-pi k (k - 1)/N`
//! for line `k` of `N`, give a low crest factor: with odd lines the peak is below 1.9 times the
//! RMS. The phase difference between lines changes by a constant amount, so that two sums replace
//! all products.

use super::phase::Quadratic;
use super::sine::{QUARTER, scaled, sine};
use crate::control::units::{Angle, angle};
use crate::parameter::ParameterError;
use crate::time::ticks;
use core::num::{NonZeroU8, NonZeroU32};

crate::parameters! {
    /// A multisine with Schroeder phases.
    pub struct MultisineParameters {
        /// Amplitude of each line; the total RMS is `sqrt(lines/2)` times this value.
        amplitude_deg [""]: 1.0, "deg", -32768.0, 32767.0, "eleven encoder counts a line, and a peak of 5.4 deg";
        /// Base frequency, of which all lines are multiples; its inverse is the period.
        base_hz ["f0"]: 0.25, "Hz", 1e-4, 100.0, "a period of 4 s";
        /// First line as a multiple of the base frequency, a whole number.
        first_line [""]: 1.0, "1", 1.0, 1000.0, "the base frequency";
        /// Spacing of the lines, a whole number.
        line_step [""]: 2.0, "1", 1.0, 1000.0, "odd lines: what appears at the even ones is not linear";
        /// Number of lines, a whole number.
        lines ["N"]: 20.0, "1", 1.0, 32.0, "up to 9.75 Hz, twice the bandwidth of 4.775 Hz";
    }
}

/// A multisine from tick 0 without end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Multisine {
    /// Amplitude of each line.
    pub amplitude: Angle,
    /// Phase of the base frequency, from [`Quadratic::steady`].
    pub phase: Quadratic,
    /// Ticks of one period of the base frequency, rounded.
    pub period_ticks: u64,
    /// First line as a multiple of the base frequency.
    pub first_line: u16,
    /// Spacing of the lines.
    pub line_step: u16,
    /// Number of lines.
    pub lines: NonZeroU8,
}

impl Multisine {
    /// A multisine with these parameters; whole numbers are rounded.
    ///
    /// ```
    /// use model_core::excitation::multisine::{Multisine, MultisineParameters};
    /// let multisine = Multisine::try_new(&MultisineParameters::default()).unwrap();
    /// // Odd lines: the second half of a period is the opposite of the first.
    /// let value = |tick| multisine.command(tick).to_f64();
    /// assert!((value(1_234) + value(41_234)).abs() < 2e-5);
    /// ```
    ///
    /// # Errors
    /// [`ParameterError::OutOfRange`] of the first parameter that is NaN or outside its range.
    pub fn try_new(parameters: &MultisineParameters) -> Result<Self, ParameterError> {
        parameters.check()?;
        let whole = |value: f64| libm::round(value) as u16;
        Ok(Self {
            amplitude: angle(parameters.amplitude_deg),
            phase: Quadratic::steady(parameters.base_hz),
            period_ticks: ticks(1.0 / parameters.base_hz),
            first_line: whole(parameters.first_line),
            line_step: whole(parameters.line_step),
            lines: NonZeroU8::new(whole(parameters.lines) as u8).unwrap_or(NonZeroU8::MIN),
        })
    }

    /// The command at a tick.
    pub fn command(&self, tick: u64) -> Angle {
        let base = self.phase.at(tick);
        // 1/N turn has an error of 2^-64 turn, multiplied by 2^15 for the last of 255 lines.
        let share = share(self.lines);
        let mut phase = base
            .wrapping_mul(self.first_line.into())
            .wrapping_add(QUARTER);
        let mut step = base.wrapping_mul(self.line_step.into());
        let mut sum = 0;
        for _ in 0..self.lines.get() {
            // At most 255 * 2^30.
            sum += i64::from(sine(phase).to_bits());
            step = step.wrapping_sub(share);
            phase = phase.wrapping_add(step);
        }
        scaled(self.amplitude, sum)
    }
}

/// `(2^64 - 1)/n`, rounded down, calculated in four 16-bit digits with 32-bit divisions.
fn share(lines: NonZeroU8) -> u64 {
    let lines = NonZeroU32::from(lines);
    let (mut share, mut rest) = (0, 0);
    for _ in 0..4 {
        // The remainder is below 255.
        let part: u32 = rest << 16 | 0xffff;
        share = share << 16 | u64::from(part / lines);
        rest = part % lines;
    }
    share
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::{PI, TAU};

    #[test]
    fn a_share_equals_a_64_bit_division() {
        for lines in 1..=u8::MAX {
            let exact = u64::MAX / u64::from(lines);
            assert_eq!(share(NonZeroU8::new(lines).unwrap()), exact, "{lines}");
        }
    }

    fn multisine(lines: f64) -> Multisine {
        let parameters = MultisineParameters {
            lines,
            ..Default::default()
        };
        Multisine::try_new(&parameters).unwrap()
    }

    #[test]
    fn the_command_is_the_sum_of_its_lines() {
        let multisine = multisine(20.0);
        for tick in (0..200_000).step_by(37) {
            let turns = 0.25 * tick as f64 / 20_000.0;
            let line = |k: u32| {
                let (k, n) = (f64::from(k), 20.0);
                libm::cos((2.0 * k - 1.0) * turns * TAU - PI * k * (k - 1.0) / n)
            };
            let sum: f64 = (1..=20).map(line).sum();
            // Half an LSB of the angle and twenty errors of the sine.
            let error = (multisine.command(tick).to_f64() - sum).abs();
            assert!(error < 7.7e-6, "{tick}: {error}");
        }
    }

    #[test]
    fn the_peak_of_any_number_of_odd_lines_is_below_1_9_times_the_rms() {
        for lines in 1..=32 {
            let multisine = multisine(f64::from(lines));
            let (mut peak, mut power) = (0_f64, 0.0);
            for tick in (0..80_000).step_by(20) {
                let value = multisine.command(tick).to_f64();
                peak = peak.max(value.abs());
                power += value * value / 4_000.0;
            }
            let rms = libm::sqrt(power);
            assert!((rms - libm::sqrt(f64::from(lines) / 2.0)).abs() < 1e-6);
            assert!(peak < 1.9 * rms, "{lines} lines: {}", peak / rms);
        }
    }
}
