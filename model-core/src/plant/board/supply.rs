//! The supply: a source with a resistance and a ripple.

use core::f64::consts::TAU;

use crate::parameter::ParameterError;
use crate::plant::drivetrain::electrical::ElectricalParameters;

use super::Defects;

crate::parameters! {
    /// The source beyond its voltage, which is the drivetrain's.
    pub struct SupplyParameters {
        /// Resistance of source and leads.
        source_resistance_ohm [""]: 0.0, "ohm", 0.0, 10.0, "ideal; a small pack with its plug: 0.1";
        /// Current of the board itself.
        board_current_a [""]: 0.06, "A", 0.0, 5.0, "STM32F427 data sheet: 45 mA typical at 168 MHz, and the transceiver";
        /// Amplitude of the ripple.
        ripple_v [""]: 0.0, "V", 0.0, 10.0, "ideal";
        /// Its frequency.
        ripple_hz [""]: 100.0, "Hz", 0.1, 100e3, "a rectifier at 50 Hz";
    }
}

#[derive(Debug, Clone)]
pub(super) struct Supply {
    parameters: SupplyParameters,
    source_v: f64,
    time_s: f64,
    /// Without any current, V, and what takes from that, ohm.
    open_v: f64,
    ohm: f64,
    volts: f64,
}

impl Supply {
    pub fn try_new(
        motor: &ElectricalParameters,
        parameters: &SupplyParameters,
    ) -> Result<Self, ParameterError> {
        parameters.check()?;
        Ok(Self {
            parameters: *parameters,
            source_v: motor.supply_v,
            time_s: 0.0,
            open_v: motor.supply_v,
            ohm: parameters.source_resistance_ohm,
            volts: motor.supply_v,
        })
    }

    /// Moves on; the bridge drew this mean current in the interval before.
    pub fn advance(&mut self, time_s: f64, bridge_a: f64, defects: &Defects) {
        let p = &self.parameters;
        self.time_s += time_s;
        let source_v = defects.source_v.unwrap_or(self.source_v);
        let ripple_v = if p.ripple_v == 0.0 {
            0.0
        } else {
            p.ripple_v * libm::sin(TAU * p.ripple_hz * self.time_s)
        };
        self.ohm = defects.source_ohm.unwrap_or(p.source_resistance_ohm);
        self.open_v = source_v + ripple_v;
        self.volts = self.under(bridge_a);
    }

    /// What is left while the bridge draws this current, V.
    pub fn under(&self, bridge_a: f64) -> f64 {
        let drawn_v = self.ohm * (bridge_a + self.parameters.board_current_a);
        (self.open_v - drawn_v).max(0.0)
    }

    pub fn volts(&self) -> f64 {
        self.volts
    }
}
