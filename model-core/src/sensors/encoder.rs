//! The AS5045 magnetic encoder: shaft angle in, serial word out.
//!
//! ```text
//! seen  = direction x shaft + zero + a1 sin(shaft + p1) + a2 sin(2 shaft + p2) + noise
//! count = floor(seen / LSB + 1/2) mod 4096                  LSB = 360/4096 deg
//! ```
//!
//! A magnet off the chip's axis makes the first two harmonics. The word follows the data sheet of
//! the AS5045 (ams, revision 1.7), section 8.1 and tables 3 to 5.

use core::f64::consts::PI;

use super::noise::Noise;

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

/// Degrees per count.
pub const LSB_DEG: f64 = 360.0 / 4096.0;

/// What the chip says of its magnet: the bits LIN, MagINC and MagDEC.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Magnet {
    /// In range, at a steady distance.
    #[default]
    Good,
    /// In range, coming closer: MagINC, for the field.
    Approaching,
    /// In range, moving away: MagDEC.
    Receding,
    /// Field weaker or stronger than recommended; the angle is less accurate.
    Marginal,
    /// Field far out of range: linearity alarm, the angle may be invalid.
    Lost,
}

impl Magnet {
    /// LIN, MagINC, MagDEC in the bits 3 to 1 of the word.
    const fn bits(self) -> u32 {
        match self {
            Self::Good => 0b000 << 1,
            Self::Approaching => 0b010 << 1,
            Self::Receding => 0b001 << 1,
            Self::Marginal => 0b011 << 1,
            Self::Lost => 0b111 << 1,
        }
    }
}

/// The chip.
#[derive(Debug, Clone)]
pub struct Encoder {
    parameters: EncoderParameters,
    noise: Noise,
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
    /// assert_eq!(encoder.count(90.0), 1024);
    /// assert_eq!(encoder.word(90.0), 1024 << 6 | 1 << 5); // OCF; two ones are even
    /// ```
    pub fn new(parameters: EncoderParameters, noise: Noise) -> Self {
        Self {
            parameters,
            noise,
            magnet: Magnet::default(),
        }
    }

    /// The count at a shaft angle, 0 to 4095; 0 for an angle that is not finite.
    pub fn count(&mut self, shaft_deg: f64) -> u16 {
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
        let seen_deg = ideal_deg + error_deg + self.noise.gaussian(p.encoder_noise_deg);
        if !seen_deg.is_finite() {
            return 0;
        }
        // `as` saturates and cuts off towards 0; one less below 0 makes it the floor. The last
        // twelve bits of two's complement are the rest modulo 4096.
        let counts = seen_deg / LSB_DEG + 0.5;
        let cut = counts as i64;
        let floor = cut.saturating_sub(i64::from(cut as f64 > counts));
        (floor & 0xfff) as u16
    }

    /// The 18 bits of the serial word at a shaft angle. D11, which is sent first, is bit 17; then
    /// down to D0, OCF, COF, LIN, MagINC, MagDEC, and in bit 0 even parity.
    pub fn word(&mut self, shaft_deg: f64) -> u32 {
        word(self.count(shaft_deg), self.magnet)
    }
}

/// The serial word of a count: offset compensation finished, no overflow.
///
/// ```
/// use model_core::sensors::encoder::{Magnet, word};
///
/// assert_eq!(word(0xfff, Magnet::Good), 0b1111_1111_1111_10_000_1);
/// ```
pub const fn word(count: u16, magnet: Magnet) -> u32 {
    const OFFSET_COMPENSATION_FINISHED: u32 = 1 << 5;
    let bits = (count as u32 & 0xfff) << 6 | OFFSET_COMPENSATION_FINISHED | magnet.bits();
    bits | (bits.count_ones() % 2)
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
        assert_eq!(e.count(0.0439), 0);
        assert_eq!(e.count(0.0440), 1);
        assert_eq!(e.count(-0.05), 4095);
        assert_eq!(e.count(360.0 * 7.0 + 45.0), 512);
        assert_eq!(e.count(359.97), 0);
    }

    #[test]
    fn zero_and_direction_turn_the_chip() {
        let mut e = encoder(EncoderParameters {
            magnet_zero_deg: 45.0,
            magnet_direction: -1.0,
            ..Default::default()
        });
        assert_eq!(e.count(45.0), 0);
        assert_eq!(e.count(-45.0), 1024);
    }

    #[test]
    fn misalignment_bends_the_angle_once_and_twice_a_turn() {
        let mut e = encoder(EncoderParameters {
            misalignment_first_deg: LSB_DEG * 8.0,
            misalignment_second_deg: LSB_DEG * 4.0,
            misalignment_second_phase_deg: 90.0,
            ..Default::default()
        });
        // 8 sin(x) + 4 cos(2 x).
        assert_eq!(e.count(0.0), 4);
        assert_eq!(e.count(90.0), 1024 + 8 - 4);
        assert_eq!(e.count(270.0), 3072 - 8 - 4);
    }

    #[test]
    fn noise_moves_the_count_about_the_angle() {
        let mut e = encoder(EncoderParameters {
            encoder_noise_deg: 0.03,
            ..Default::default()
        });
        // On the edge of two counts they come half of the time each; one more is 3 sigma away.
        let edge = 0.5 * LSB_DEG;
        let ones = (0..10_000).filter(|_| e.count(edge) == 1).count();
        // Three standard errors, and a few that reach beyond.
        assert!((4820..5180).contains(&ones), "{ones}");
    }

    #[test]
    fn the_alarms_stand_in_their_own_bits() {
        assert_eq!(word(0, Magnet::Good), 0b10_0001);
        assert_eq!(word(0, Magnet::Receding), 0b10_0010);
        assert_eq!(word(0, Magnet::Approaching), 0b10_0100);
        assert_eq!(word(0, Magnet::Marginal), 0b10_0111);
        assert_eq!(word(0, Magnet::Lost), 0b10_1110);
    }

    proptest! {
        #[test]
        fn every_word_has_even_parity_eighteen_bits_and_its_count(
            count in 0u16..4096,
            magnet in prop::sample::select(&[
                Magnet::Good, Magnet::Approaching, Magnet::Receding, Magnet::Marginal, Magnet::Lost,
            ][..])
        ) {
            let word = word(count, magnet);
            prop_assert_eq!(word.count_ones() % 2, 0);
            prop_assert_eq!(word >> 6, u32::from(count));
            // OCF set, COF clear.
            prop_assert_eq!(word >> 4 & 0b11, 0b10);
        }

        #[test]
        fn the_ideal_count_is_that_of_the_referee(angle in -32000.0..32000.0f64) {
            let n = (angle / LSB_DEG + 0.5).floor() as i64;
            let mut e = encoder(EncoderParameters::default());
            prop_assert_eq!(i64::from(e.count(angle)), n.rem_euclid(4096));
        }

        #[test]
        fn any_angle_gives_a_count(angle in any::<f64>(), amplitude in 0.0..10.0) {
            let mut e = encoder(EncoderParameters {
                misalignment_first_deg: amplitude,
                ..Default::default()
            });
            prop_assert!(e.count(angle) < 4096);
        }
    }
}
