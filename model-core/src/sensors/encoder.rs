//! The AS5045 magnetic encoder: shaft angle in, serial word out.
//!
//! ```text
//! seen  = direction x shaft + zero + a1 sin(shaft + p1) + a2 sin(2 shaft + p2) + noise
//! count = floor(seen / LSB + 1/2) mod 4096                  LSB = 360/4096 deg
//! ```
//!
//! A magnet off the chip's axis causes the first two harmonics. The word format is that of
//! [`crate::control::encoder_word`].

use core::{f64::consts::PI, hint::cold_path};

use super::noise::Noise;
use crate::control::encoder_word::{COUNT_DEG, EncoderCount, EncoderWord, Magnet};

crate::parameters! {
    /// The encoder's mounting and errors.
    pub struct EncoderParameters {
        /// Angle measured at the shaft's zero.
        magnet_zero_deg [""]: 0.0, "deg", -360.0, 360.0, "ideal";
        /// Direction: 1 if the measured angle increases with the shaft's, -1 if it decreases.
        magnet_direction [""]: 1.0, "1", -1.0, 1.0, "ideal";
        /// Noise of the angle, rms.
        encoder_noise_deg [""]: 0.0, "deg", 0.0, 10.0, "ideal; AS5045 data sheet: transition noise 0.03 deg rms";
        /// Amplitude of the once-per-turn error of an eccentric magnet.
        misalignment_first_deg [""]: 0.0, "deg", 0.0, 10.0, "ideal; AS5045 data sheet: 1.4 deg within the alignment tolerance";
        /// Phase of the once-per-turn error.
        misalignment_first_phase_deg [""]: 0.0, "deg", -360.0, 360.0, "ideal";
        /// Amplitude of the twice-per-turn error.
        misalignment_second_deg [""]: 0.0, "deg", 0.0, 10.0, "ideal; AS5045 data sheet: 0.5 deg with the magnet centred";
        /// Phase of the twice-per-turn error.
        misalignment_second_phase_deg [""]: 0.0, "deg", -360.0, 360.0, "ideal";
    }
}

/// The encoder chip.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Encoder {
    #[cfg_attr(feature = "serde", serde(with = "crate::parameter::as_values"))]
    parameters: EncoderParameters,
    /// The noise to come.
    pub(crate) noise: Noise,
    /// Whether the encoder is ideal, as in most campaigns, where the error terms need not be
    /// computed.
    is_ideal: bool,
    /// Status of the magnet.
    pub magnet: Magnet,
}

impl Encoder {
    /// An encoder with a correct magnet; parameters are not checked against their ranges.
    ///
    /// ```
    /// use model_core::sensors::{encoder::{Encoder, EncoderParameters}, noise::Noise};
    ///
    /// let mut encoder = Encoder::new(EncoderParameters::default(), Noise::new(0, 0));
    /// assert_eq!(encoder.count(90.0).get(), 1024);
    /// ```
    pub fn new(parameters: EncoderParameters, noise: Noise) -> Self {
        Self {
            is_ideal: parameters == EncoderParameters::DEFAULT,
            parameters,
            noise,
            magnet: Magnet::default(),
        }
    }

    /// The count at a shaft angle; 0 if the angle is not finite.
    #[inline]
    pub fn count(&mut self, shaft_deg: f64) -> EncoderCount {
        let seen_deg = if self.is_ideal {
            shaft_deg
        } else {
            self.seen_deg(shaft_deg)
        };
        // The low twelve bits of two's complement are the value modulo 4096.
        EncoderCount::new(floor_u16(seen_deg / COUNT_DEG + 0.5))
    }

    /// The measured angle with all errors.
    fn seen_deg(&mut self, shaft_deg: f64) -> f64 {
        let p = &self.parameters;
        let harmonic = |amplitude: f64, order: f64, phase: f64| {
            if amplitude == 0.0 {
                0.0
            } else {
                amplitude * libm::sin((order * shaft_deg + phase) * (PI / 180.0))
            }
        };
        let error_deg = harmonic(
            p.misalignment_first_deg,
            1.0,
            p.misalignment_first_phase_deg,
        ) + harmonic(
            p.misalignment_second_deg,
            2.0,
            p.misalignment_second_phase_deg,
        );
        let direction = if p.magnet_direction < 0.0 { -1.0 } else { 1.0 };
        let ideal_deg = direction * shaft_deg + p.magnet_zero_deg;
        ideal_deg + error_deg + self.noise.gaussian(p.encoder_noise_deg)
    }

    /// The count at a shaft angle, `None` if its word is not valid: what the control step sees of
    /// [`Encoder::word`].
    #[inline]
    pub fn valid_count(&mut self, shaft_deg: f64) -> Option<EncoderCount> {
        let count = self.count(shaft_deg);
        (self.magnet != Magnet::Lost).then_some(count)
    }

    /// The serial word at a shaft angle.
    #[inline]
    pub fn word(&mut self, shaft_deg: f64) -> EncoderWord {
        EncoderWord::of(self.count(shaft_deg), self.magnet)
    }
}

/// The low 16 bits of the value rounded down; 0 for a value that is not finite.
#[inline(always)]
fn floor_u16(value: f64) -> u16 {
    if value.abs() < (1_u64 << 50) as f64 {
        return floor_bits(value) as u16;
    }
    if !value.is_finite() {
        return 0;
    }
    // `as` saturates and truncates towards 0; subtracting one below 0 makes it the floor.
    let cut = value as i64;
    cut.saturating_sub(i64::from(cut as f64 > value)) as u16
}

/// The numbers from here to its double are the integers: adding it rounds to the nearest one, which
/// then stands in the low bits.
const INTEGERS: f64 = (3_u64 << 51) as f64;

/// A number whose low 48 bits are those of the value rounded down, for magnitudes below 2^50.
#[inline(always)]
fn floor_bits(value: f64) -> i64 {
    let sum = value + INTEGERS;
    let is_above = sum - INTEGERS > value;
    (sum.to_bits() as i64).wrapping_sub(i64::from(is_above))
}

/// The counts of ideal encoders with correct magnets at these angles, below 2^40 deg; bits above
/// the twelfth are not cleared.
///
/// A product with the reciprocal, rounded to the nearest integer, is the count wherever rounding
/// does not matter. It is twenty cycles faster than the division and the comparison of
/// [`Encoder::count`], which decide near the edge between two counts.
#[inline(always)]
pub fn ideal_counts<const N: usize>(shafts_deg: &[f64; N]) -> [i64; N] {
    /// Product and quotient are off by less than 2^-51 of themselves: 2^-31 counts below 2^20.
    const CLEAR: f64 = 0.5 - 1e-6;
    const LARGE: f64 = (1_u64 << 20) as f64;
    let mut counts = [0; N];
    let mut is_unclear = false;
    for lane in 0..N {
        let value = shafts_deg[lane] * (1.0 / COUNT_DEG);
        let sum = value + INTEGERS;
        counts[lane] = sum.to_bits() as i64;
        let rest = value - (sum - INTEGERS);
        // Not true for NaN either.
        is_unclear |= !((rest.abs() < CLEAR) & (value.abs() < LARGE));
    }
    if is_unclear {
        cold_path();
        for lane in 0..N {
            counts[lane] = floor_bits(shafts_deg[lane] / COUNT_DEG + 0.5);
        }
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn encoder(parameters: EncoderParameters) -> Encoder {
        Encoder::new(parameters, Noise::new(1, 0))
    }

    #[test]
    fn the_ideal_count_is_the_nearest_and_wraps() {
        let mut e = encoder(EncoderParameters::default());
        assert_eq!(e.count(0.0439).get(), 0);
        assert_eq!(e.count(0.0440).get(), 1);
        assert_eq!(e.count(-0.05).get(), 4095);
        assert_eq!(e.count(360.0 * 7.0 + 45.0).get(), 512);
        assert_eq!(e.count(359.97).get(), 0);
    }

    #[test]
    fn zero_and_direction_transform_the_angle() {
        let mut e = encoder(EncoderParameters {
            magnet_zero_deg: 45.0,
            magnet_direction: -1.0,
            ..Default::default()
        });
        assert_eq!(e.count(45.0).get(), 0);
        assert_eq!(e.count(-45.0).get(), 1024);
    }

    #[test]
    fn misalignment_adds_errors_once_and_twice_per_turn() {
        let mut e = encoder(EncoderParameters {
            misalignment_first_deg: COUNT_DEG * 8.0,
            misalignment_second_deg: COUNT_DEG * 4.0,
            misalignment_second_phase_deg: 90.0,
            ..Default::default()
        });
        // 8 sin(x) + 4 cos(2 x).
        assert_eq!(e.count(0.0).get(), 4);
        assert_eq!(e.count(90.0).get(), 1024 + 8 - 4);
        assert_eq!(e.count(270.0).get(), 3072 - 8 - 4);
    }

    #[test]
    fn noise_spreads_the_count_around_the_angle() {
        let mut e = encoder(EncoderParameters {
            encoder_noise_deg: 0.03,
            ..Default::default()
        });
        // On the edge of two counts each occurs half of the time; the next count is 3 sigma away.
        let edge = 0.5 * COUNT_DEG;
        let ones = (0..10_000).filter(|_| e.count(edge).get() == 1).count();
        // Three standard errors, plus a few counts beyond the two.
        assert!((4820..5180).contains(&ones), "{ones}");
    }

    proptest! {
        #[test]
        fn the_ideal_count_is_that_of_the_referee(angle in -32000.0..32000.0f64) {
            let n = (angle / COUNT_DEG + 0.5).floor() as i64;
            let mut e = encoder(EncoderParameters::default());
            prop_assert_eq!(i64::from(e.count(angle).get()), n.rem_euclid(4096));
        }

        #[test]
        fn several_ideal_counts_are_those_of_one_encoder_at_any_angle_and_at_the_edges(
            angle in prop_oneof![-32000.0..32000.0f64, -1e9..1e9f64],
            edge in -364_000_i32..364_000, steps in -3_i64..4,
        ) {
            let edge = (f64::from(edge) + 0.5) * COUNT_DEG;
            let near = f64::from_bits(edge.to_bits().wrapping_add_signed(steps));
            let mut e = encoder(EncoderParameters::default());
            for angles in [[angle, near], [near, near], [angle, angle]] {
                let counts = ideal_counts(&angles).map(|count| count & 4095);
                prop_assert_eq!(counts, angles.map(|angle| i64::from(e.count(angle).get())));
            }
        }

        #[test]
        fn rounding_down_is_that_of_the_standard_library(
            value in prop_oneof![-1e3..1e3, -1e16..1e16, any::<f64>()], whole in -4_100_i16..4_100
        ) {
            let around = f64::from(whole);
            for value in [value, around, around.next_up(), around.next_down()] {
                let floor = value.floor();
                // Beyond 2^63 the cast saturates.
                let expected = if value.is_finite() { (floor as i64) as u16 } else { 0 };
                prop_assert_eq!(floor_u16(value), expected, "{}", value);
            }
        }

        #[test]
        fn a_valid_count_is_that_of_the_word(angle in -400.0..400.0, magnet in 0..5_usize) {
            let mut e = encoder(EncoderParameters::default());
            use Magnet::*;
            e.magnet = [Steady, Approaching, Receding, Marginal, Lost][magnet];
            let of_word = e.word(angle).read().ok().map(|reading| reading.count);
            prop_assert_eq!(e.valid_count(angle), of_word);
        }

        #[test]
        fn any_angle_gives_a_count(angle in any::<f64>(), amplitude in 0.0..10.0) {
            let mut e = encoder(EncoderParameters {
                misalignment_first_deg: amplitude,
                ..Default::default()
            });
            prop_assert!(e.count(angle).get() < 4096);
        }
    }
}
