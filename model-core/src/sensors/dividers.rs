//! Voltage dividers of supply, motor legs and temperature on the board.
//!
//! | quantity | at the pin | range |
//! |---|---|---|
//! | supply | [`SUPPLY_DIVIDER`] of it | 0 to 16.5 V |
//! | each leg of the motor | [`LEG_DIVIDER`] of it | 0 to 9.9 V |
//! | temperature | ratio of the divider of [`NTC_PULL_UP_OHM`] and the NTC | -40 to 125 deg C |
//!
//! With the bridge off, equal resistors to supply and ground hold the floating winding at half the
//! supply: leg A is at `(supply + back-EMF)/2`, leg B at `(supply - back-EMF)/2`, and neither is
//! below ground. The back-EMF is the difference.

use super::adc::AdcCode;
pub use super::board_figures::{
    LEG_DIVIDER, LEG_SETTLING_S, NTC_B_K, NTC_OHM, NTC_PULL_UP_OHM, SUPPLY_DIVIDER,
};

/// 0 deg C, K.
const ZERO_CELSIUS_K: f64 = 273.15;

/// The code of a supply voltage, V.
///
/// ```
/// assert_eq!(model_core::sensors::dividers::supply_code(6.0).bits(), 1489); // 1.2 V / 3.3 V x 4096
/// ```
pub fn supply_code(supply_v: f64) -> AdcCode {
    AdcCode::from_pin_v(supply_v * SUPPLY_DIVIDER)
}

/// The code of a leg's voltage, V.
///
/// ```
/// assert_eq!(model_core::sensors::dividers::leg_code(3.0).bits(), 1241); // 1 V / 3.3 V x 4096
/// ```
pub fn leg_code(leg_v: f64) -> AdcCode {
    AdcCode::from_pin_v(leg_v * LEG_DIVIDER)
}

/// Share of the difference from the last conversion that a conversion of a leg still shows: the
/// sampling capacitor, 4 pF (STM32F427 data sheet, table 74), shares its charge with the 1 nF at
/// the pin, which recovers through 6.7 kohm during the sampling phase of 84 cycles of 21 MHz.
pub fn leg_charge_share() -> f64 {
    const SAMPLING_S: f64 = 84.0 / 21e6;
    4e-12 / (1e-9 + 4e-12) * libm::exp(-SAMPLING_S / LEG_SETTLING_S)
}

/// Measured by true back-EMF. The supply, leg A and leg B are converted in this order; with the
/// share `g` of [`leg_charge_share`] and legs at `(supply +- e)/2`
///
/// ```text
/// a = A + g (supply - A)    b = B + g (A - B)    a - b = e (1 - 3 g/2) + g supply/2
/// ```
///
/// The last term is a constant offset.
pub fn back_emf_gain() -> f64 {
    1.0 - 1.5 * leg_charge_share()
}

/// The code of a temperature, deg C: `R = R25 exp(B (1/T - 1/T25))`.
///
/// ```
/// use model_core::sensors::dividers::temperature_code;
/// assert_eq!(temperature_code(25.0).bits(), 2048);
/// assert!(temperature_code(80.0) < temperature_code(20.0));
/// ```
pub fn temperature_code(temperature_deg_c: f64) -> AdcCode {
    let kelvin = temperature_deg_c + ZERO_CELSIUS_K;
    let exponent = NTC_B_K * (1.0 / kelvin - 1.0 / (25.0 + ZERO_CELSIUS_K));
    let ohm = NTC_OHM * libm::exp(exponent);
    AdcCode::from_pin_v(AdcCode::LSB_V * 4096.0 * ohm / (ohm + NTC_PULL_UP_OHM))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ntc_resistances_match_its_b_value() {
        // 10k B3950: 33.6 kohm at 0 deg C, 3.59 kohm at 50 deg C, 0.697 kohm at 100 deg C.
        for (temperature_deg_c, ohm) in [(0.0, 33_621.0), (50.0, 3_588.0), (100.0, 697.0)] {
            let code = f64::from(temperature_code(temperature_deg_c).bits());
            let expected = 4096.0 * ohm / (ohm + NTC_PULL_UP_OHM);
            assert!((code - expected).abs() < 1.0, "{temperature_deg_c}: {code}");
        }
    }

    #[test]
    fn an_open_ntc_gives_the_largest_code_and_a_short_the_smallest() {
        assert_eq!(temperature_code(-200.0), AdcCode::MAX);
        assert!(temperature_code(1000.0).bits() < 5);
    }
}
