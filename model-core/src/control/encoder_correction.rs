//! The correction of the encoder's error, which repeats with each turn of the shaft.
//!
//! ```text
//! h(x) = c1 cos x + s1 sin x + c2 cos 2x + s2 sin 2x          by the angle x of the shaft
//! e(y) = h(y - e(y)), nearly h(y)/(1 + h'(y))                 by the angle y of the encoder
//! ```
//!
//! A magnet off the chip's axis causes these two harmonics ([`crate::sensors::encoder`]). Both
//! angles are those of the encoder: from its count 0, in its direction. The corrected angle is
//! `y - (e(y) - e(zero))`, so that the zero of the [`Mounting`] stays where it is. What the
//! quotient, a step of Newton's method, misses in `e` is `h'' e^2/2`: at 1.4 deg once and 0.5 deg
//! twice a turn 2 mdeg.
//!
//! A control step interpolates a table of 32 intervals. Twice a turn an interval is 22.5 deg,
//! 0.393 rad, of which a straight line misses an eighth of the square: 1.9 % of the amplitude,
//! 10 mdeg of 0.5 deg, a ninth of a count.

use super::{
    encoder_word::COUNTS_PER_TURN,
    shaft_tracker::{COUNT_STEPS, Mounting},
    units::Angle,
};

/// Intervals of the table.
const INTERVALS: usize = 32;

/// Counts of an interval, as a power of two.
const INTERVAL_BITS: u32 = (COUNTS_PER_TURN as u32 / INTERVALS as u32).ilog2();

/// An entry of the table is in 2^-7 counts.
const ENTRY_BITS: u32 = 7;

/// Units of an entry in a radian.
const UNITS_PER_RAD: f32 =
    ((COUNTS_PER_TURN as u32) << ENTRY_BITS) as f32 / (2.0 * core::f32::consts::PI);

/// A deviation is in 2^-14 counts: an entry, interpolated between the counts of an interval.
const DEVIATION_BITS: u32 = ENTRY_BITS + INTERVAL_BITS;

/// Cosine and sine of 2^k counts.
const ROTATIONS: [(f32, f32); 12] = [
    (0.999_998_8, 0.001_533_980_1),
    (0.999_995_3, 0.003_067_956_8),
    (0.999_981_16, 0.006_135_884_7),
    (0.999_924_7, 0.012_271_538),
    (0.999_698_8, 0.024_541_229),
    (0.998_795_45, 0.049_067_676),
    (0.995_184_7, 0.098_017_14),
    (0.980_785_25, 0.195_090_32),
    (0.923_879_5, 0.382_683_43),
    (0.707_106_77, 0.707_106_77),
    (0.0, 1.0),
    (-1.0, 0.0),
];

/// A deviation of the encoder, in 2^-14 counts: below 2^23.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Deviation(i32);

impl Deviation {
    /// None.
    pub const NONE: Self = Self(0);

    /// The angle, in whole steps, as a count has 45 * 2^23 of them.
    pub const fn angle(self) -> Angle {
        Angle::from_bits(self.0 as i64 * (COUNT_STEPS >> DEVIATION_BITS))
    }
}

/// Greatest magnitude of a field of [`EncoderHarmonics`]: twice the 1.4 deg that the data sheet of
/// the AS5045 permits once a turn, rounded up; mdeg.
pub const GREATEST_HARMONIC_MDEG: i16 = 3000;

/// The error of an encoder by the angle of the shaft, which is that of the encoder less this error:
/// from its count 0, in its direction. Each field is within [`GREATEST_HARMONIC_MDEG`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub struct EncoderHarmonics {
    /// Cosine and sine once a turn, mdeg.
    pub first_mdeg: (i16, i16),
    /// Cosine and sine twice a turn, mdeg.
    pub second_mdeg: (i16, i16),
}

/// The deviation of a mounted encoder from the angle of the shaft, as a table over a turn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct EncoderCorrection {
    /// The deviation at the start of each interval from the mounting's zero, in the direction of
    /// positive duty. `h` is within 4.25 deg once and as much twice a turn, and `h'` within 0.23:
    /// the difference of two errors is within 22.1 deg, 32,186 units.
    table: [i16; INTERVALS],
}

impl EncoderCorrection {
    /// No deviation.
    pub const NONE: Self = Self {
        table: [0; INTERVALS],
    };

    /// The correction of an encoder with this error.
    ///
    /// ```
    /// use model_core::control::encoder_correction::{EncoderCorrection, EncoderHarmonics};
    /// use model_core::control::encoder_word::EncoderCount;
    /// use model_core::control::{shaft_tracker::Mounting, units::angle};
    ///
    /// let once = EncoderHarmonics { first_mdeg: (0, 1400), ..Default::default() };
    /// let mounting = Mounting { zero: EncoderCount::new(0), reversed: false };
    /// let correction = EncoderCorrection::new(&once, mounting);
    /// let quarter_turn = correction.deviation(1024).angle();
    /// assert!((quarter_turn.to_f64() - 1.4).abs() < 1e-3);
    /// assert_eq!(correction.deviation(0).angle(), angle(0.0));
    /// ```
    pub fn new(harmonics: &EncoderHarmonics, mounting: Mounting) -> Self {
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
        let sign = if mounting.reversed { -1.0 } else { 1.0 };
        let (cos, sin) = ROTATIONS[INTERVAL_BITS as usize];
        let mut at = direction(mounting.zero.get());
        let mut at_zero = None;
        let table = core::array::from_fn(|_| {
            let error = error(at);
            let entry = sign * (error - *at_zero.get_or_insert(error)) * UNITS_PER_RAD;
            at = rotated(at, (cos, sin * sign));
            // `as` saturates.
            libm::roundf(entry) as i16
        });
        Self { table }
    }

    /// Whether the deviation is another one somewhere. A comparison of the tables by `!=` is one of
    /// bytes on the board.
    pub fn differs_from(&self, other: &Self) -> bool {
        self.table.iter().zip(&other.table).any(|(a, b)| a != b)
    }

    /// The deviation at this many counts from the mounting's zero, in the direction of positive
    /// duty.
    pub fn deviation(&self, counts: i32) -> Deviation {
        let of_turn = counts as u32 % COUNTS_PER_TURN as u32;
        let (interval, within) = (of_turn >> INTERVAL_BITS, of_turn % (1 << INTERVAL_BITS));
        let at = |interval: u32| i32::from(self.table[interval as usize % INTERVALS]);
        let (start, end) = (at(interval), at(interval + 1));
        // |start| < 2^15 and |end - start| < 2^16, both times 2^7 at most.
        Deviation((start << INTERVAL_BITS) + (end - start) * within as i32)
    }
}

/// Cosine and sine of an angle that is turned by another one.
#[cfg_attr(target_os = "none", inline(never))]
fn rotated((cos, sin): (f32, f32), (by_cos, by_sin): (f32, f32)) -> (f32, f32) {
    (cos * by_cos - sin * by_sin, sin * by_cos + cos * by_sin)
}

/// Cosine and sine of the angle of a count.
fn direction(count: u16) -> (f32, f32) {
    let bits = ROTATIONS.iter().enumerate();
    let set = bits.filter(|(bit, _)| count >> bit & 1 != 0);
    set.fold((1.0, 0.0), |at, (_, by)| rotated(at, *by))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::encoder_word::EncoderCount;
    use proptest::prelude::*;

    const RAD_PER_MDEG: f64 = core::f64::consts::PI / 180e3;

    /// The error at an angle of the encoder, rad, as the solution of its equation; mdeg.
    fn solved(harmonics: &EncoderHarmonics, y: f64) -> f64 {
        let h = |x: f64| {
            let of = |(c, s): (i16, i16), x: f64| {
                f64::from(c) * libm::cos(x) + f64::from(s) * libm::sin(x)
            };
            of(harmonics.first_mdeg, x) + of(harmonics.second_mdeg, 2.0 * x)
        };
        (0..50).fold(0.0, |e, _| h(y - e * RAD_PER_MDEG))
    }

    proptest! {
        /// A table entry is rounded to half a unit, 0.35 mdeg; a line misses 0.48 % of the first
        /// and 1.9 % of the second harmonic. Newton's step misses `h'' e^2/2`, of which `e` has
        /// another 2 % by its slope, at both ends of a difference. The harmonics reach 1.4 times
        /// those of the data sheet.
        #[test]
        fn the_deviation_is_the_solution_of_the_equation_for_every_mounting(
            first_mdeg in (-1400_i16..1400, -1400_i16..1400),
            second_mdeg in (-500_i16..500, -500_i16..500),
            (zero, reversed) in (0_u16..4096, any::<bool>()),
            counts in -10_000_i32..10_000
        ) {
            let harmonics = EncoderHarmonics { first_mdeg, second_mdeg };
            let mounting = Mounting { zero: EncoderCount::new(zero), reversed };
            let correction = EncoderCorrection::new(&harmonics, mounting);
            let sign = if reversed { -1.0 } else { 1.0 };
            let at = |counts: f64| {
                let count = f64::from(zero) + sign * counts;
                solved(&harmonics, count * core::f64::consts::TAU / f64::from(COUNTS_PER_TURN))
            };
            let found = correction.deviation(counts).angle().to_f64() * 1e3;
            let missed = (found - sign * (at(f64::from(counts)) - at(0.0))).abs();
            let amplitude = |(c, s): (i16, i16)| f64::from(c).hypot(f64::from(s));
            let (once, twice) = (amplitude(first_mdeg), amplitude(second_mdeg));
            let largest = (once + twice) * 1.1 * RAD_PER_MDEG;
            let newton = (once + 4.0 * twice) * largest * largest;
            let bound = 0.36 + 0.005 * once + 0.02 * twice + newton;
            prop_assert!(missed < bound, "{missed} mdeg of {bound}");
        }
    }

    #[test]
    fn the_table_holds_the_greatest_harmonics() {
        let ends = [-GREATEST_HARMONIC_MDEG, GREATEST_HARMONIC_MDEG];
        let pairs = || ends.into_iter().flat_map(|c| ends.map(|s| (c, s)));
        for (first_mdeg, second_mdeg) in pairs().flat_map(|one| pairs().map(move |two| (one, two)))
        {
            let harmonics = EncoderHarmonics {
                first_mdeg,
                second_mdeg,
            };
            for zero in (0..4096).step_by(64) {
                let mounting = Mounting {
                    zero: EncoderCount::new(zero),
                    reversed: false,
                };
                let EncoderCorrection { table } = EncoderCorrection::new(&harmonics, mounting);
                let is_whole = table
                    .iter()
                    .all(|entry| entry.unsigned_abs() < i16::MAX as u16);
                assert!(is_whole, "{harmonics:?}");
            }
        }
    }
}
