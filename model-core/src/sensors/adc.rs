//! Analogue front ends of motor current and back-EMF, and the 12-bit ADC.
//!
//! ```text
//! pin voltage = offset + gain x quantity x (1 + gain error) + noise
//! code        = floor(pin voltage / LSB + 1/2), limited to 0..=4095
//! ```

use super::board_figures::{ADC_REFERENCE_V, CURRENT_GAIN_V_A, CURRENT_OFFSET_V, CURRENT_SWING_V};
use super::noise::Noise;

/// Result of a conversion: 0 to 4095.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct AdcCode(u16);

impl AdcCode {
    /// Volts per code: 12 bits of a 3.3 V reference (STM32F427, section ADC).
    pub const LSB_V: f64 = ADC_REFERENCE_V / 4096.0;

    /// The largest code.
    pub const MAX: Self = Self(4095);

    /// The content of the ADC's data register: the low 12 bits of `bits`.
    ///
    /// ```
    /// assert_eq!(model_core::sensors::adc::AdcCode::new(0x1801).bits(), 0x801);
    /// ```
    pub const fn new(bits: u16) -> Self {
        Self(bits & Self::MAX.0)
    }

    /// The code of a voltage at the pin, V; saturates at both ends, 0 for NaN.
    ///
    /// ```
    /// use model_core::sensors::adc::AdcCode;
    ///
    /// assert_eq!(AdcCode::from_pin_v(1.65).bits(), 2048);
    /// assert_eq!(AdcCode::from_pin_v(5.0), AdcCode::MAX);
    /// ```
    pub fn from_pin_v(pin_v: f64) -> Self {
        // `as` saturates at 0 and converts NaN to 0.
        let code = libm::floor(pin_v / Self::LSB_V + 0.5) as u16;
        Self(code.min(Self::MAX.0))
    }

    /// The code as a number.
    pub const fn bits(self) -> u16 {
        self.0
    }

    /// The voltage in the middle of the code, V.
    pub fn pin_v(self) -> f64 {
        f64::from(self.0) * Self::LSB_V
    }
}

crate::parameters! {
    /// Front end of the motor current: shunt with bidirectional amplifier.
    pub struct CurrentSenseParameters {
        /// Volts at the pin per ampere.
        current_gain_v_a [""]: CURRENT_GAIN_V_A, "V/A", 1e-3, 1000.0, "INA240A2 (50 V/V) with 10 mohm: +-2.9 A, and a reversal at full rate takes 1.84 A";
        /// Volts at the pin without current.
        current_offset_v [""]: CURRENT_OFFSET_V, "V", 0.0, 3.3, "estimate: half the reference, for both signs";
        /// Relative error of the gain.
        current_gain_error [""]: 0.0, "1", -0.5, 0.5, "ideal";
        /// Error of the offset.
        current_offset_error_v [""]: 0.0, "V", -3.3, 3.3, "ideal";
        /// Standard deviation of the noise at the pin.
        current_noise_v [""]: 0.0, "V", 0.0, 3.3, "ideal";
    }
}

crate::parameters! {
    /// Front end of the back-EMF: a differential amplifier across the motor, read with the bridge
    /// off.
    pub struct BackEmfSenseParameters {
        /// Volts at the pin per volt.
        back_emf_gain [""]: 0.25, "V/V", 1e-3, 1000.0, "estimate: +-6.6 V, the supply and a tenth";
        /// Volts at the pin at standstill.
        back_emf_offset_v [""]: 1.65, "V", 0.0, 3.3, "estimate: half the reference, for both signs";
        /// Relative error of the gain.
        back_emf_gain_error [""]: 0.0, "1", -0.5, 0.5, "ideal";
        /// Error of the offset.
        back_emf_offset_error_v [""]: 0.0, "V", -3.3, 3.3, "ideal";
        /// Standard deviation of the noise at the pin.
        back_emf_noise_v [""]: 0.0, "V", 0.0, 3.3, "ideal";
    }
}

/// A front end with the ADC.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrontEnd {
    gain: f64,
    offset_v: f64,
    gain_error: f64,
    offset_error_v: f64,
    noise_v: f64,
    /// Least and greatest output voltage of the amplifier, V.
    swing_v: (f64, f64),
}

impl From<&CurrentSenseParameters> for FrontEnd {
    fn from(p: &CurrentSenseParameters) -> Self {
        Self {
            gain: p.current_gain_v_a,
            offset_v: p.current_offset_v,
            gain_error: p.current_gain_error,
            offset_error_v: p.current_offset_error_v,
            noise_v: p.current_noise_v,
            swing_v: CURRENT_SWING_V,
        }
    }
}

impl From<&BackEmfSenseParameters> for FrontEnd {
    fn from(p: &BackEmfSenseParameters) -> Self {
        Self {
            gain: p.back_emf_gain,
            offset_v: p.back_emf_offset_v,
            gain_error: p.back_emf_gain_error,
            offset_error_v: p.back_emf_offset_error_v,
            noise_v: p.back_emf_noise_v,
            swing_v: (0.0, ADC_REFERENCE_V),
        }
    }
}

impl FrontEnd {
    /// Converts a quantity, A or V, to a code.
    ///
    /// ```
    /// use model_core::sensors::{adc::{CurrentSenseParameters, FrontEnd}, noise::Noise};
    ///
    /// let current = FrontEnd::from(&CurrentSenseParameters::default());
    /// let code = current.convert(1.0, &mut Noise::new(0, 0));
    /// assert_eq!(code.bits(), 2669); // (1.65 + 0.5) V / 3.3 V x 4096 = 2668.6
    /// ```
    pub fn convert(&self, quantity: f64, noise: &mut Noise) -> AdcCode {
        let ideal_v = self.offset_v + self.gain * quantity * (1.0 + self.gain_error);
        let output_v = ideal_v + self.offset_error_v;
        let (least_v, most_v) = self.swing_v;
        // NaN stays NaN and gives code 0.
        let output_v = crate::limits::within(output_v, least_v, most_v);
        AdcCode::from_pin_v(output_v + noise.gaussian(self.noise_v))
    }

    /// Converts a code to the quantity, A or V, with nominal gain and offset, as the board does.
    pub fn quantity(&self, code: AdcCode) -> f64 {
        (code.pin_v() - self.offset_v) / self.gain
    }

    /// The quantity per code, A or V.
    pub fn lsb(&self) -> f64 {
        AdcCode::LSB_V / self.gain
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn quiet() -> Noise {
        Noise::new(0, 0)
    }

    #[test]
    fn codes_saturate_at_0_and_4095() {
        let ends = [-1.0, f64::NEG_INFINITY, f64::NAN].map(|v| AdcCode::from_pin_v(v).bits());
        assert_eq!(ends, [0, 0, 0]);
        let ends = [3.3, 1e9, f64::INFINITY].map(AdcCode::from_pin_v);
        assert_eq!(ends, [AdcCode::MAX; 3]);
    }

    #[test]
    fn the_current_range_ends_at_the_swing_of_the_amplifier() {
        let current = FrontEnd::from(&CurrentSenseParameters::default());
        let ends =
            [4.0, -4.0].map(|amperes| current.quantity(current.convert(amperes, &mut quiet())));
        // (3.1 - 1.65) V and (0.01 - 1.65) V over 0.5 V/A, within half a code.
        assert!(
            (ends[0] - 2.9).abs() < 1e-3 && (ends[1] + 3.28).abs() < 1e-3,
            "{ends:?}"
        );
    }

    #[test]
    fn gain_and_offset_errors_are_not_corrected() {
        let sense = FrontEnd::from(&BackEmfSenseParameters {
            back_emf_gain_error: 0.1,
            back_emf_offset_error_v: 0.05,
            ..Default::default()
        });
        let seen = sense.quantity(sense.convert(4.0, &mut quiet()));
        // 4 V x 1.1 + 0.05/0.25 V.
        assert!((seen - 4.6).abs() <= sense.lsb() / 2.0 + 1e-12);
    }

    #[test]
    fn noise_of_several_codes_has_the_specified_deviation() {
        let sense = FrontEnd::from(&CurrentSenseParameters {
            current_noise_v: 0.01,
            ..Default::default()
        });
        let mut noise = Noise::new(3, 0);
        let square: f64 = (0..10_000)
            .map(|_| sense.quantity(sense.convert(0.0, &mut noise)))
            .map(|a| a * a)
            .sum();
        let rms = libm::sqrt(square / 1e4);
        // 10 mV over 0.5 V/A; three standard errors of 0.7 %, plus 0.03 % of quantisation.
        assert!((rms / 0.02 - 1.0).abs() < 0.025);
    }

    proptest! {
        #[test]
        fn within_the_range_the_conversion_error_is_at_most_half_a_code(volts in -6.59..6.59) {
            let sense = FrontEnd::from(&BackEmfSenseParameters::default());
            let seen = sense.quantity(sense.convert(volts, &mut quiet()));
            prop_assert!((seen - volts).abs() <= sense.lsb() / 2.0 + 1e-12);
        }

        #[test]
        fn any_quantity_gives_a_code(quantity in any::<f64>()) {
            let sense = FrontEnd::from(&CurrentSenseParameters::default());
            prop_assert!(sense.convert(quantity, &mut quiet()) <= AdcCode::MAX);
        }
    }
}
