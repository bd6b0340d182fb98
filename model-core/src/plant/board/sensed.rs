//! The analogue front ends and the codes that the converter makes of them.

use crate::parameter::ParameterError;
use crate::sensors::adc::{AdcCode, FrontEnd};
use crate::sensors::dividers::{LEG_DIVIDER, SUPPLY_DIVIDER, leg_charge_share};
use crate::sensors::noise::Noise;

use super::{BoardPlantOptions, SsiWord};

/// The last samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Sensed {
    /// What a transfer from the encoder reads, at the last edge.
    pub encoder: SsiWord,
    /// The motor current in the last on time.
    pub current: AdcCode,
    /// The legs of the motor at the scan's instant.
    pub legs: Legs,
    /// The supply at the instant of the current.
    pub supply: AdcCode,
    /// The temperature at the scan's instant.
    pub temperature: AdcCode,
}

/// The codes of the two legs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Legs {
    /// Leg A.
    pub a: AdcCode,
    /// Leg B.
    pub b: AdcCode,
}

#[derive(Debug, Clone)]
pub(super) struct FrontEnds {
    pub ambient_deg_c: f64,
    current: FrontEnd,
    current_noise: Noise,
    pin_noise: Noise,
    pin_noise_v: f64,
    /// Voltage that the converter's sampling capacitor holds from the last conversion, V.
    held_v: f64,
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
            held_v: 0.0,
        })
    }

    fn noise_v(&mut self) -> f64 {
        self.pin_noise.gaussian(self.pin_noise_v)
    }

    /// The code of the motor current.
    pub fn current(&mut self, current_a: f64) -> AdcCode {
        self.current.convert(current_a, &mut self.current_noise)
    }

    /// The code of the supply. Its 10 nF hold the pin against the sampling capacitor.
    pub fn supply(&mut self, supply_v: f64) -> AdcCode {
        self.held_v = supply_v * SUPPLY_DIVIDER;
        AdcCode::from_pin_v(self.held_v + self.noise_v())
    }

    /// The codes of the legs at these voltages, converted one after the other.
    pub fn legs(&mut self, legs_v: [f64; 2]) -> Legs {
        let [a, b] = legs_v.map(|leg_v| {
            // The converter's clamp holds the pin at ground.
            let pin_v = leg_v.max(0.0) * LEG_DIVIDER;
            let sampled_v = pin_v + (self.held_v - pin_v) * leg_charge_share();
            self.held_v = pin_v;
            AdcCode::from_pin_v(sampled_v + self.noise_v())
        });
        Legs { a, b }
    }
}
