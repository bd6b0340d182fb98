//! The analogue front ends and the codes that the converter makes of them.

use crate::parameter::ParameterError;
use crate::sensors::adc::{AdcCode, FrontEnd};
use crate::sensors::dividers::{LEG_DIVIDER, SUPPLY_DIVIDER, temperature_code};
use crate::sensors::noise::Noise;

use super::{BoardPlantOptions, SsiWord};

/// What the pins show until the next boundary.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sensed {
    /// What a transfer from the encoder reads.
    pub encoder: SsiWord,
    /// The motor current.
    pub current: AdcCode,
    /// The legs of the motor.
    pub legs: Legs,
    /// The supply.
    pub supply: AdcCode,
    /// The temperature.
    pub temperature: AdcCode,
}

/// The codes of the two legs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Legs {
    /// Leg A.
    pub a: AdcCode,
    /// Leg B.
    pub b: AdcCode,
}

pub(super) struct Quantities {
    pub current_a: f64,
    pub supply_v: f64,
    pub temperature_deg_c: f64,
}

#[derive(Debug, Clone)]
pub(super) struct FrontEnds {
    pub ambient_deg_c: f64,
    current: FrontEnd,
    current_noise: Noise,
    pin_noise: Noise,
    pin_noise_v: f64,
    /// What the noise adds to the legs until the next boundary, V.
    leg_noise_v: [f64; 2],
}

impl FrontEnds {
    pub fn try_new(
        options: &BoardPlantOptions,
        noise: impl Fn(u64) -> Noise,
    ) -> Result<Self, ParameterError> {
        options.current.check()?;
        Ok(Self {
            ambient_deg_c: options.ambient_deg_c,
            current: FrontEnd::from(&options.current),
            current_noise: noise(1),
            pin_noise: noise(2),
            pin_noise_v: options.pin_noise_v,
            leg_noise_v: [0.0; 2],
        })
    }

    fn noise_v(&mut self) -> f64 {
        self.pin_noise.gaussian(self.pin_noise_v)
    }

    /// Draws all noise anew; the encoder's word is the caller's.
    pub fn sense(&mut self, quantities: &Quantities, legs_v: [f64; 2]) -> Sensed {
        self.leg_noise_v = [self.noise_v(), self.noise_v()];
        let supply_pin_v = quantities.supply_v * SUPPLY_DIVIDER + self.noise_v();
        // The NTC's filter is slow against any noise.
        let temperature = temperature_code(quantities.temperature_deg_c);
        Sensed {
            encoder: SsiWord::default(),
            current: self
                .current
                .convert(quantities.current_a, &mut self.current_noise),
            legs: self.legs(legs_v),
            supply: AdcCode::from_pin_v(supply_pin_v),
            temperature,
        }
    }

    /// The legs at these voltages, with the noise of the last boundary.
    pub fn legs(&self, legs_v: [f64; 2]) -> Legs {
        let code = |leg: usize| {
            AdcCode::from_pin_v(legs_v[leg].max(0.0) * LEG_DIVIDER + self.leg_noise_v[leg])
        };
        Legs {
            a: code(0),
            b: code(1),
        }
    }
}
