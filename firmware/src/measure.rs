//! Conversion of ADC codes to mA, mV and thousandths of a degree Celsius, in integers.
//!
//! Gains and offsets are computed from those of `model_core::sensors` at compile time, so that the
//! board and its simulated front ends cannot differ.

mod motor;
mod ntc;
mod ripple;
mod single;

use model_core::sensors::{
    adc::{AdcCode, CurrentSenseParameters},
    dividers::{LEG_DIVIDER, SUPPLY_DIVIDER},
};

pub use motor::{MotorConstants, Thermal};
pub use ntc::temperature_mdeg_c;
pub use ripple::{PeriodCurrent, Ripple};
pub use single::Single;

/// Linear conversion of codes to thousandths of a unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct LinearConversion {
    /// In 2^-16 thousandths per code.
    slope: i32,
    /// In 2^-16 thousandths.
    offset: i32,
}

/// 1 in 2^-16.
const ONE: f64 = 65_536.0;

impl LinearConversion {
    /// Inverse of a front end: pin voltage = offset + gain x quantity.
    const fn of(gain: f64, offset_v: f64) -> Self {
        Self {
            slope: (AdcCode::LSB_V / gain * 1000.0 * ONE + 0.5) as i32,
            offset: (-offset_v / gain * 1000.0 * ONE) as i32,
        }
    }

    const fn at(self, code: i32) -> i32 {
        // The greatest slope is that of the supply: 4.03 mV per code are 264,000 < 2^19, and |code|
        // < 2^12; the greatest offset is the current's, 3300 mA, 2.2e8 < 2^28.
        (code * self.slope + self.offset + (1 << 15)) >> 16
    }
}

const CURRENT: LinearConversion = LinearConversion::of(
    CurrentSenseParameters::DEFAULT.current_gain_v_a,
    CurrentSenseParameters::DEFAULT.current_offset_v,
);
const LEGS: LinearConversion = LinearConversion::of(LEG_DIVIDER, 0.0);
const SUPPLY: LinearConversion = LinearConversion::of(SUPPLY_DIVIDER, 0.0);

/// The motor current of a code, mA.
///
/// ```
/// use firmware::measure::current_ma;
/// use model_core::sensors::adc::AdcCode;
/// assert_eq!([2048, 2669, 0].map(|code| current_ma(AdcCode::new(code))), [0, 1001, -3300]);
/// ```
pub const fn current_ma(code: AdcCode) -> i32 {
    CURRENT.at(code.bits() as i32)
}

/// Code of a leg that is at ground: 39 mV. While a diode still carries the winding's current after
/// the switches have opened, one leg is a diode's drop below ground, and the other one as much
/// above the supply.
const LEG_AT_GROUND: u16 = 16;

/// A motor at its full rate has a leg at ground too, and the other one at the supply: within the
/// resolution and the error of the dividers below it, and above it by what the supply gives way
/// under the current, less than a diode's drop.
const BELOW_SUPPLY_MV: i32 = 100;
const ABOVE_SUPPLY_MV: i32 = 200;

/// The back-EMF of the codes of both legs with the bridge off, and of the supply, mV; positive
/// where leg A is higher. `None` if a diode conducts, where the difference is the supply, or if a
/// leg is not measured.
///
/// ```
/// use firmware::measure::back_emf_mv;
/// use model_core::sensors::dividers::{leg_code, supply_code};
/// let supply = supply_code(6.0);
/// assert_eq!(back_emf_mv(leg_code(5.0), leg_code(1.0), supply), Some(4000));
/// assert_eq!(back_emf_mv(leg_code(5.98), leg_code(0.02), supply), Some(5960));
/// // A diode conducts; a leg is open.
/// assert_eq!(back_emf_mv(leg_code(6.7), leg_code(0.0), supply), None);
/// assert_eq!(back_emf_mv(leg_code(4.0), leg_code(0.0), supply), None);
/// ```
pub const fn back_emf_mv(leg_a: AdcCode, leg_b: AdcCode, supply: AdcCode) -> Option<i32> {
    let (a, b) = (leg_a.bits(), leg_b.bits());
    if a < LEG_AT_GROUND || b < LEG_AT_GROUND {
        let higher = if a > b { a } else { b };
        let above_mv = LEGS.at(higher as i32) - supply_mv(supply);
        if above_mv < -BELOW_SUPPLY_MV || above_mv > ABOVE_SUPPLY_MV {
            return None;
        }
    }
    Some(LEGS.at(a as i32 - b as i32))
}

/// Whether a diode conducts: a leg is above the supply, and its divider works.
pub const fn diode_conducts(leg_a: AdcCode, leg_b: AdcCode, supply: AdcCode) -> bool {
    let (a, b) = (leg_a.bits(), leg_b.bits());
    let higher = if a > b { a } else { b };
    LEGS.at(higher as i32) > supply_mv(supply) + ABOVE_SUPPLY_MV
}

/// The supply voltage of a code, mV.
///
/// ```
/// use firmware::measure::supply_mv;
/// use model_core::sensors::dividers::supply_code;
/// assert_eq!(supply_mv(supply_code(6.0)), 5998); // a code is 4 mV
/// ```
pub const fn supply_mv(code: AdcCode) -> i32 {
    SUPPLY.at(code.bits() as i32)
}

#[cfg(test)]
mod tests {
    use model_core::sensors::{adc::FrontEnd, noise::Noise};
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn the_current_is_that_of_the_front_end_rounded_to_ma(code in 0u16..4096) {
            let code = AdcCode::new(code);
            let front_end = FrontEnd::from(&CurrentSenseParameters::DEFAULT);
            let exact_ma = front_end.quantity(code) * 1000.0;
            // Rounding to a mA, and the rounding of the slope times 4095 codes.
            prop_assert!((f64::from(current_ma(code)) - exact_ma).abs() < 0.5 + 0.04);
        }

        #[test]
        fn legs_and_supply_are_recovered_within_a_code(a in 0.1..9.8, b in 0.1..9.8, supply in 0.0..16.4) {
            use model_core::sensors::dividers::{leg_code, supply_code};
            let difference_mv = f64::from(back_emf_mv(leg_code(a), leg_code(b), supply_code(6.0)).expect("off ground"));
            // A code of a leg is 2.42 mV: half of it each, and half a mV.
            prop_assert!((difference_mv - (a - b) * 1000.0).abs() < 2.42 + 0.6);
            prop_assert!((f64::from(supply_mv(supply_code(supply))) - supply * 1000.0).abs() < 2.02 + 0.6);
        }
    }

    #[test]
    fn zero_current_is_measured_as_zero() {
        let front_end = FrontEnd::from(&CurrentSenseParameters::DEFAULT);
        let code = front_end.convert(0.0, &mut Noise::new(0, 0));
        assert_eq!(current_ma(code), 0);
    }
}
