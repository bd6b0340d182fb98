//! Protections, and what the table reports.

use servo_bus::dynamixel::{Control, Measured, error};
use servo_bus::tables::x;

use super::{FULL_PWM, VELOCITY_UNIT, X};

/// Output from which an overload counts, and for how long, ms.
const OVERLOAD_DUTY: f64 = 0.8;
const OVERLOAD_MS: i32 = 1000;

impl X {
    /// The errors that are present.
    fn errors(&mut self) -> i32 {
        let sensed = *self.motor.sensed();
        let is_at_rest = sensed.rate.abs() < self.real(x::MOVING_THRESHOLD) * VELOCITY_UNIT;
        let is_loaded = sensed.duty.abs() >= OVERLOAD_DUTY && is_at_rest;
        self.overload_ms = if is_loaded {
            self.overload_ms.saturating_add(1)
        } else {
            0
        };
        let (voltage, temperature) = self.motor.supply_and_temperature();
        let is_overloaded = self.overload_ms > OVERLOAD_MS;
        Control::out_of_range(&self.server.memory, voltage, temperature)
            | if is_overloaded { error::OVERLOAD } else { 0 }
    }

    pub(super) fn publish(&mut self) {
        let errors = self.errors();
        let sensed = self.motor.sensed();
        let (voltage, temperature) = self.motor.supply_and_temperature();
        let velocity = Control::velocity_units(self.ramp.velocity());
        let measured = Measured {
            shaft: sensed.position,
            rate: (sensed.rate / VELOCITY_UNIT).round() as i32,
            pwm: (sensed.duty * FULL_PWM).round() as i32,
            current: (sensed.current_a / self.current_unit_a).round() as i32,
            voltage,
            temperature,
            trajectory: (self.ramp.position(), velocity),
            errors,
        };
        self.control.report(&mut self.server.memory, &measured);
    }
}
