//! Voltages of the motor's legs at the instant of the scan.
//!
//! After the switches open, a current in the winding keeps flowing through two diodes, which hold
//! one leg at the supply and the other at ground:
//!
//! ```text
//! L di/dt = -(V + 2 Vd) sign(i) - R i - e      until i = 0, after t_c
//! ```
//!
//! Then equal resistors hold the floating motor at half the supply, and the dividers' capacitors
//! settle with [`LEG_SETTLING_S`].

use crate::control::pwm_timer::{BACK_EMF_INSTANT, TIMER_DIVIDER, WINDOW_START};
use crate::plant::drivetrain::electrical::ElectricalParameters;
use crate::sensors::dividers::LEG_SETTLING_S;

use super::bridge::Connection;
use super::slot::seconds;

/// Time from the start of the window to the scan, s.
fn window_to_scan_s() -> f64 {
    seconds((BACK_EMF_INSTANT - WINDOW_START) * TIMER_DIVIDER)
}

#[derive(Debug, Clone)]
pub(super) struct LegVoltages {
    resistance_ohm: f64,
    time_constant_s: f64,
    diode_drop_v: f64,
    supply_v: f64,
    /// Current and back-EMF at the start of the window.
    opened: (f64, f64),
}

impl LegVoltages {
    pub fn new(motor: &ElectricalParameters) -> Self {
        Self {
            resistance_ohm: motor.winding_resistance_ohm,
            time_constant_s: motor.winding_inductance_h / motor.winding_resistance_ohm,
            diode_drop_v: motor.diode_drop_v,
            supply_v: motor.supply_v,
            opened: (0.0, 0.0),
        }
    }

    /// The window starts with this current and back-EMF.
    pub fn open(&mut self, current_a: f64, back_emf_v: f64) {
        self.opened = (current_a, back_emf_v);
    }

    /// Time for which the diodes conduct from the start of the window on, s; infinite while the
    /// back-EMF exceeds the supply in the direction of the current.
    fn conduction_s(&self) -> f64 {
        let (current_a, back_emf_v) = self.opened;
        if current_a == 0.0 {
            return 0.0;
        }
        let against_v = self.supply_v + 2.0 * self.diode_drop_v;
        // Of the current's magnitude.
        let steady_a = -(against_v + back_emf_v * current_a.signum()) / self.resistance_ohm;
        if steady_a >= 0.0 {
            return f64::INFINITY;
        }
        self.time_constant_s * libm::log((current_a.abs() - steady_a) / -steady_a)
    }

    /// Voltages of the legs at the instant of the scan, V.
    pub fn at_sample(
        &mut self,
        connection: Connection,
        supply_v: f64,
        back_emf_v: f64,
    ) -> [f64; 2] {
        self.supply_v = supply_v;
        match connection {
            Connection::Shorted => [0.0; 2],
            Connection::Supply(sign) if sign > 0.0 => [supply_v, 0.0],
            Connection::Supply(_) => [0.0, supply_v],
            Connection::Open => self.open_legs(supply_v, back_emf_v),
        }
    }

    fn open_legs(&self, supply_v: f64, back_emf_v: f64) -> [f64; 2] {
        let (low_v, high_v) = (-self.diode_drop_v, supply_v + self.diode_drop_v);
        // A current into leg A comes from ground through a diode and returns to the supply.
        let rails = if self.opened.0 > 0.0 {
            [low_v, high_v]
        } else {
            [high_v, low_v]
        };
        let settling_s = window_to_scan_s() - self.conduction_s();
        if settling_s <= 0.0 {
            return rails;
        }
        let left = libm::exp(-settling_s / LEG_SETTLING_S);
        let floating = [(supply_v + back_emf_v) / 2.0, (supply_v - back_emf_v) / 2.0];
        core::array::from_fn(|leg| {
            let settled_v = floating[leg].clamp(low_v, high_v);
            settled_v + (rails[leg] - settled_v) * left
        })
    }
}
