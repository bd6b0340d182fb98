//! The AS5045 magnetic encoder: shaft angle in, serial word out.
//!
//! ```text
//! seen  = direction x shaft + zero + a1 sin(shaft + p1) + a2 sin(2 shaft + p2) + noise
//! count = floor(seen / LSB + 1/2) mod 4096                  LSB = 360/4096 deg
//! ```
//!
//! A magnet off the chip's axis makes the first two harmonics. The word is that of
//! [`crate::control::encoder_word`].

use core::f64::consts::PI;

use super::noise::Noise;
use crate::control::encoder_word::{COUNT_DEG, EncoderCount, EncoderWord, Magnet};

crate::parameters! {
    /// The encoder's mounting and errors.
    pub struct EncoderParameters {
        /// Angle that the chip sees at the shaft's zero.
        magnet_zero_deg [""]: 0.0, "deg", -360.0, 360.0, "ideal";
        /// Sense of the chip: 1 where its angle grows with the shaft's, -1 where it falls.
        magnet_direction [""]: 1.0, "1", -1.0, 1.0, "ideal";
        /// Noise of the angle, rms.
        encoder_noise_deg [""]: 0.0, "deg", 0.0, 10.0, "ideal; AS5045 data sheet: transition noise 0.03 deg rms";
        /// Amplitude of the error once a turn, of an eccentric magnet.
        misalignment_first_deg [""]: 0.0, "deg", 0.0, 10.0, "ideal; AS5045 data sheet: 1.4 deg within the alignment tolerance";
        /// Its phase.
        misalignment_first_phase_deg [""]: 0.0, "deg", -360.0, 360.0, "ideal";
        /// Amplitude of the error twice a turn.
        misalignment_second_deg [""]: 0.0, "deg", 0.0, 10.0, "ideal; AS5045 data sheet: 0.5 deg with the magnet centred";
        /// Its phase.
        misalignment_second_phase_deg [""]: 0.0, "deg", -360.0, 360.0, "ideal";
    }
}

/// The chip.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Encoder {
    #[cfg_attr(feature = "serde", serde(with = "crate::parameter::as_values"))]
    parameters: EncoderParameters,
    noise: Noise,
    /// Whether it sees the shaft's own angle: most campaigns run so, and a control step is short.
    is_ideal: bool,
    /// What it says of its magnet.
    pub magnet: Magnet,
}

impl Encoder {
    /// A chip with a good magnet; parameters outside their ranges are taken as they are.
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

    /// The count at a shaft angle; 0 for an angle that is not finite.
    #[inline]
    pub fn count(&mut self, shaft_deg: f64) -> EncoderCount {
        let seen_deg = if self.is_ideal {
            shaft_deg
        } else {
            self.seen_deg(shaft_deg)
        };
        if !seen_deg.is_finite() {
            return EncoderCount::new(0);
        }
        // `as` saturates and cuts off towards 0; one less below 0 makes it the floor. The last
        // twelve bits of two's complement, which the count keeps, are the rest modulo 4096.
        let counts = seen_deg / COUNT_DEG + 0.5;
        let cut = counts as i64;
        let floor = cut.saturating_sub(i64::from(cut as f64 > counts));
        EncoderCount::new(floor as u16)
    }

    /// What the chip sees, with all its errors.
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

    /// The serial word at a shaft angle.
    #[inline]
    pub fn word(&mut self, shaft_deg: f64) -> EncoderWord {
        EncoderWord::of(self.count(shaft_deg), self.magnet)
    }
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
    fn zero_and_direction_turn_the_chip() {
        let mut e = encoder(EncoderParameters {
            magnet_zero_deg: 45.0,
            magnet_direction: -1.0,
            ..Default::default()
        });
        assert_eq!(e.count(45.0).get(), 0);
        assert_eq!(e.count(-45.0).get(), 1024);
    }

    #[test]
    fn misalignment_bends_the_angle_once_and_twice_a_turn() {
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
    fn noise_moves_the_count_about_the_angle() {
        let mut e = encoder(EncoderParameters {
            encoder_noise_deg: 0.03,
            ..Default::default()
        });
        // On the edge of two counts they come half of the time each; one more is 3 sigma away.
        let edge = 0.5 * COUNT_DEG;
        let ones = (0..10_000).filter(|_| e.count(edge).get() == 1).count();
        // Three standard errors, and a few that reach beyond.
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
        fn any_angle_gives_a_count(angle in any::<f64>(), amplitude in 0.0..10.0) {
            let mut e = encoder(EncoderParameters {
                misalignment_first_deg: amplitude,
                ..Default::default()
            });
            prop_assert!(e.count(angle).get() < 4096);
        }
    }
}
