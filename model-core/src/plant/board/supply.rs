//! The supply: a source with a resistance and a ripple, and the capacitor at the bridge.
//!
//! ```text
//! C dv/dt = (open - v)/R - i
//! ```
//!
//! With the mean current `i` of an interval the voltage approaches `open - R i` exponentially. The
//! interval sees the voltage at its start.

use core::f64::consts::TAU;

use crate::parameter::ParameterError;
use crate::plant::drivetrain::electrical::ElectricalParameters;

use super::Defects;

crate::parameters! {
    /// The source beyond its voltage, which is the drivetrain's.
    pub struct SupplyParameters {
        /// Resistance of source and leads.
        source_resistance_ohm [""]: 0.0, "ohm", 0.0, 10.0, "ideal; a small pack with its plug: 0.1";
        /// Capacitance at the bridge.
        capacitance_f [""]: 470e-6, "F", 0.0, 1.0, "C1 of the actuator's board";
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
    /// At the start of the interval, and its length.
    volts: f64,
    interval_s: f64,
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
            interval_s: 0.0,
        })
    }

    /// Begins an interval of this length; in that before the bridge drew this mean current.
    pub fn advance(&mut self, time_s: f64, bridge_a: f64, defects: &Defects) {
        self.volts = self.after(bridge_a);
        let p = &self.parameters;
        self.interval_s = time_s;
        self.time_s += time_s;
        let source_v = defects.source_v.unwrap_or(self.source_v);
        let ripple_v = if p.ripple_v == 0.0 {
            0.0
        } else {
            p.ripple_v * libm::sin(TAU * p.ripple_hz * self.time_s)
        };
        self.ohm = defects.source_ohm.unwrap_or(p.source_resistance_ohm);
        self.open_v = source_v + ripple_v;
        // A source without a resistance decides on the voltage at once.
        if self.ohm == 0.0 {
            self.volts = self.open_v;
        }
    }

    /// The voltage at the end of the interval, in which the bridge draws this mean current, V.
    pub fn after(&self, bridge_a: f64) -> f64 {
        let drawn_v = self.ohm * (bridge_a + self.parameters.board_current_a);
        let settled_v = (self.open_v - drawn_v).max(0.0);
        let constant_s = self.ohm * self.parameters.capacitance_f;
        if constant_s == 0.0 {
            return settled_v;
        }
        settled_v + (self.volts - settled_v) * libm::exp(-self.interval_s / constant_s)
    }

    pub fn volts(&self) -> f64 {
        self.volts
    }
}
