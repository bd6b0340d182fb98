//! The correction of the encoder's error, which is periodic with the turn of the shaft.
//!
//! ```text
//! h(x) = c1 cos x + s1 sin x + c2 cos 2x + s2 sin 2x          by the angle x of the shaft
//! e(y) = h(y - e(y)), nearly h(y)/(1 + h'(y))                 by the angle y of the encoder
//! ```
//!
//! A magnet off the chip's axis causes these two harmonics ([`crate::sensors::encoder`]). The angle
//! of the shaft is `y - (e(y) - e(0))`, so that zero stays where it is. What the quotient, a step of
//! Newton's method, misses is `h'' e^2/2`: at 1.4 deg once and 0.5 deg twice a turn 2 mdeg.
//!
//! A control step interpolates a table of 32 intervals. Twice a turn an interval is 22.5 deg, 0.393
//! rad, of which a straight line misses an eighth of the square: 1.9 % of the amplitude, 10 mdeg of
//! 0.5 deg. A finer one would not fit into the memory of the loop.

use super::{encoder_word::COUNTS_PER_TURN, shaft_tracker::COUNT_STEPS, units::Angle};

/// Intervals of the table.
const INTERVALS: usize = 32;

/// Counts of an interval, as a power of two.
const INTERVAL_BITS: u32 = (COUNTS_PER_TURN as u32 / INTERVALS as u32).ilog2();

/// Parts of a count in which the table is written, as a power of two.
const PART_BITS: u32 = 7;

/// Parts of a count in a radian.
const PARTS_PER_RAD: f32 =
    ((COUNTS_PER_TURN as u32) << PART_BITS) as f32 / (2.0 * core::f32::consts::PI);

/// Fractions of a count in which an error is computed, as a power of two: parts of an interpolation.
const FRACTION_BITS: u32 = PART_BITS + INTERVAL_BITS;

/// Cosine and sine of an interval, 2 pi/32.
const ROTATION: (f32, f32) = (0.980_785_25, 0.195_090_32);

/// An error of an encoder, in fractions of a count: below 2^22.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CountError(i32);

impl CountError {
    /// None.
    pub const NONE: Self = Self(0);

    /// The angle; whole steps, as a count has 45 * 2^23 of them.
    pub const fn angle(self) -> Angle {
        Angle::from_bits(self.0 as i64 * (COUNT_STEPS >> FRACTION_BITS))
    }
}

/// Greatest magnitude of an [`EncoderHarmonics`] field: twice what the data sheet of the AS5045
/// permits once a turn, 1.4 deg, and a reserve; mdeg.
pub const GREATEST_HARMONIC_MDEG: i16 = 3000;

/// The error of an encoder by the angle of the shaft in the direction of positive duty, each within
/// [`GREATEST_HARMONIC_MDEG`]. The shaft is at zero where the encoder less this error is at its
/// zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub struct EncoderHarmonics {
    /// Cosine and sine once a turn, mdeg.
    pub first_mdeg: (i16, i16),
    /// Cosine and sine twice a turn, mdeg.
    pub second_mdeg: (i16, i16),
}

/// The error of an encoder as a table over a turn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct EncoderCorrection {
    /// The error at the begin of each interval, in parts of a count. `h` is within 4.25 deg once and
    /// as much twice a turn, and `h'` within 0.23: the difference of two errors is within 22.1 deg,
    /// 32,186 parts.
    table: [i16; INTERVALS],
}

impl EncoderCorrection {
    /// No error.
    pub const NONE: Self = Self {
        table: [0; INTERVALS],
    };

    /// The correction of this error.
    ///
    /// ```
    /// use model_core::control::encoder_correction::{EncoderCorrection, EncoderHarmonics};
    /// use model_core::control::units::angle;
    ///
    /// let once = EncoderHarmonics { first_mdeg: (0, 1400), ..Default::default() };
    /// let correction = EncoderCorrection::new(&once);
    /// let quarter_turn = correction.error(1024).angle();
    /// assert!((quarter_turn.to_f64() - 1.4).abs() < 1e-3);
    /// assert_eq!(correction.error(0).angle(), angle(0.0));
    /// ```
    pub fn new(harmonics: &EncoderHarmonics) -> Self {
        let rad = |mdeg: i16| {
            let limited = mdeg.clamp(-GREATEST_HARMONIC_MDEG, GREATEST_HARMONIC_MDEG);
            f32::from(limited) * (core::f32::consts::PI / 180e3)
        };
        let pair = |(cosine, sine): (i16, i16)| (rad(cosine), rad(sine));
        let (c1, s1) = pair(harmonics.first_mdeg);
        let (c2, s2) = pair(harmonics.second_mdeg);
        let error = |(cos, sin): (f32, f32)| {
            let (cos_2, sin_2) = (cos * cos - sin * sin, 2.0 * cos * sin);
            let h = c1 * cos + s1 * sin + c2 * cos_2 + s2 * sin_2;
            let slope = s1 * cos - c1 * sin + 2.0 * (s2 * cos_2 - c2 * sin_2);
            h / (1.0 + slope)
        };
        let mut at = (1.0, 0.0);
        let at_zero = error(at);
        let table = core::array::from_fn(|_| {
            let parts = (error(at) - at_zero) * PARTS_PER_RAD;
            at = (
                at.0 * ROTATION.0 - at.1 * ROTATION.1,
                at.1 * ROTATION.0 + at.0 * ROTATION.1,
            );
            // `as` saturates.
            libm::roundf(parts) as i16
        });
        Self { table }
    }

    /// The error at this many counts from zero.
    pub fn error(&self, counts: i32) -> CountError {
        let of_turn = counts as u32 % COUNTS_PER_TURN as u32;
        let (interval, within) = (of_turn >> INTERVAL_BITS, of_turn % (1 << INTERVAL_BITS));
        let at = |interval: u32| i32::from(self.table[interval as usize % INTERVALS]);
        let (begin, end) = (at(interval), at(interval + 1));
        // |begin| < 2^15 and |end - begin| < 2^16, both times 2^7 at most.
        CountError((begin << INTERVAL_BITS) + (end - begin) * within as i32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// A table entry is rounded to half a part, 0.35 mdeg; a line misses 0.48 % of the first
        /// and 1.9 % of the second harmonic. Newton's step misses `h'' e^2/2`, of which `e` has
        /// another 2 % by its slope. The harmonics reach twice those of the data sheet.
        #[test]
        fn the_error_solves_the_equation_of_the_shaft(
            first in (-2000_i16..2000, -2000_i16..2000),
            second in (-700_i16..700, -700_i16..700),
            counts in -10_000_i32..10_000
        ) {
            let harmonics = EncoderHarmonics { first_mdeg: first, second_mdeg: second };
            let correction = EncoderCorrection::new(&harmonics);
            let h = |x: f64| {
                let of = |(c, s): (i16, i16), x: f64| {
                    f64::from(c) * libm::cos(x) + f64::from(s) * libm::sin(x)
                };
                of(first, x) + of(second, 2.0 * x)
            };
            const RAD_PER_MDEG: f64 = core::f64::consts::PI / 180e3;
            let solved = |y: f64| (0..20).fold(0.0, |e, _| h(y - e * RAD_PER_MDEG));
            let y = f64::from(counts) * core::f64::consts::TAU / f64::from(COUNTS_PER_TURN);
            let found = correction.error(counts).angle().to_f64() * 1e3;
            let missed = (found - (solved(y) - solved(0.0))).abs();
            let amplitude = |(c, s): (i16, i16)| f64::from(c).hypot(f64::from(s));
            let (once, twice) = (amplitude(first), amplitude(second));
            let largest = (once + twice) * 1.1 * RAD_PER_MDEG;
            let newton = (once + 4.0 * twice) * largest * largest;
            let bound = 0.36 + 0.005 * once + 0.02 * twice + newton;
            prop_assert!(missed < bound, "{missed} mdeg of {bound}");
        }
    }
}
