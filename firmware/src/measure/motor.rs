//! What the protections know of the motor: object 2011h as constants of a control period.

use super::{Ripple, single::Single};
use crate::{parameters::ModelSettings, timing::CONTROL_PERIOD_MS};

/// Degrees per radian.
const DEG: f32 = 180.0 / core::f32::consts::PI;

/// 1 in 2^-8.
const ONE: f32 = 256.0;

/// Winding and gears of the motor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct MotorConstants {
    /// The ripple of its current.
    pub ripple: Ripple,
    /// Rate of the shaft per back-EMF, mdeg/s per mV, in 2^-8.
    rate_per_mv: i32,
    thermal: [Single; 4],
}

/// How winding and housing warm in a control period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Thermal {
    /// Rise of the winding at 25 deg C, K per mA^2: `R T/Cw`.
    pub heating: f32,
    /// Share of its excess over the housing that the winding loses: `T/(Rwh Cw)`.
    pub winding_rate: f32,
    /// Share of that excess by which the housing rises: `T/(Rwh Ch)`.
    pub housing_gain: f32,
    /// Share of its excess over the air that the housing loses: `T/(Rha Ch)`.
    pub housing_rate: f32,
}

impl MotorConstants {
    /// Greatest rate per back-EMF, mdeg/s per mV in 2^-8: times 16.5 V, the greatest voltage of a
    /// leg, it is below 2^31. A motor of less than 2 mV per deg/s turns faster than is expected of
    /// it.
    const GREATEST: f32 = 130_000.0;

    /// Those of a motor.
    ///
    /// ```
    /// use firmware::{measure::MotorConstants, parameters::ModelSettings};
    ///
    /// // 0.00362 N m/A and gears of 320 are 1.1584 V per rad/s: 5.73 V are 4.9465 rad/s.
    /// let motor = MotorConstants::of(&ModelSettings::DEFAULT);
    /// assert_eq!(motor.rate_mdeg_s(5730), 283_411);
    /// ```
    pub fn of(model: &ModelSettings) -> Self {
        let v_s_rad = model.torque_constant_nm_a * model.gear_ratio;
        // 1 mV is so many mdeg/s as 1 V is deg/s.
        let rate_per_mv = ONE * DEG / v_s_rad;
        Self {
            ripple: Ripple::of(model.resistance_ohm, model.inductance_h),
            rate_per_mv: if rate_per_mv > Self::GREATEST {
                Self::GREATEST as i32
            } else {
                rate_per_mv as i32
            },
            thermal: thermal(model).map(Single::new),
        }
    }

    /// Whether both motors have the same back-EMF.
    pub fn has_back_emf_of(&self, other: &Self) -> bool {
        self.rate_per_mv == other.rate_per_mv
    }

    /// How the motor warms.
    pub fn thermal(&self) -> Thermal {
        let [heating, winding_rate, housing_gain, housing_rate] = self.thermal.map(Single::get);
        Thermal {
            heating,
            winding_rate,
            housing_gain,
            housing_rate,
        }
    }

    /// Rate of the shaft with this back-EMF, mdeg/s.
    pub const fn rate_mdeg_s(&self, back_emf_mv: i32) -> i32 {
        (back_emf_mv * self.rate_per_mv) >> 8
    }

    /// Back-EMF at this rate of the shaft, mV; that of 8,000 deg/s at most.
    ///
    /// ```
    /// use firmware::{measure::MotorConstants, parameters::ModelSettings};
    ///
    /// let motor = MotorConstants::of(&ModelSettings::DEFAULT);
    /// assert_eq!([283_411, i32::MIN].map(|rate| motor.back_emf_mv(rate)), [5729, -161_743]);
    /// ```
    pub const fn back_emf_mv(&self, rate_mdeg_s: i32) -> i32 {
        // Times 2^8 below 2^31.
        let end = 8_000_000;
        let rate = if rate_mdeg_s > end {
            end
        } else if rate_mdeg_s < -end {
            -end
        } else {
            rate_mdeg_s
        };
        match (rate << 8).checked_div(self.rate_per_mv) {
            Some(back_emf_mv) => back_emf_mv,
            None => 0,
        }
    }
}

/// The factors of [`Thermal`], with the capacities `Cw = Tw/Rwh` and `Ch = Th/Rha`.
fn thermal(model: &ModelSettings) -> [f32; 4] {
    let period_s = CONTROL_PERIOD_MS as f32 * 1e-3;
    let ModelSettings {
        winding_housing_k_w: inner_k_w,
        housing_ambient_k_w: outer_k_w,
        winding_time_s,
        housing_time_s,
        ..
    } = *model;
    let winding_rate = period_s / winding_time_s;
    let housing_rate = period_s / housing_time_s;
    [
        // A mA^2 is 1e-6 A^2.
        model.resistance_ohm * 1e-6 * winding_rate * inner_k_w,
        winding_rate,
        housing_rate * outer_k_w / inner_k_w,
        housing_rate,
    ]
}
