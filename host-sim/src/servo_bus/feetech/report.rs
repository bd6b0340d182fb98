//! Protections, and what the table reports.

use servo_bus::feetech::{Control, Measured, status};
use servo_bus::tables::sts;

use super::Sts;

impl Sts {
    pub(super) fn protect(&mut self) {
        let sensed = *self.motor.sensed();
        let acts = self.get(sts::UNLOADING_CONDITION);
        let overload = f64::from(self.get(sts::OVERLOAD_TORQUE)) / 100.0;
        let is_overloaded = self.latched & status::OVERLOAD == 0
            && sensed.duty.abs() > overload
            && sensed.rate.abs() < 50.0;
        if self
            .overload
            .exceeds(is_overloaded, 10 * self.get(sts::PROTECTION_TIME))
        {
            self.latched |= status::OVERLOAD & acts;
        }
        let most_a = f64::from(self.get(sts::PROTECTION_CURRENT)) * self.current_unit_a;
        let is_high = most_a > 0.0 && sensed.current_a.abs() > most_a;
        if self
            .overcurrent
            .exceeds(is_high, 10 * self.get(sts::OVERCURRENT_TIME))
        {
            self.latched |= status::CURRENT & acts;
        }
        let ends = status::CURRENT & self.latched
            | (status::TEMPERATURE | status::VOLTAGE) & self.present() & acts;
        if ends != 0 && self.control.torque != 0 {
            self.control.turn_off(&mut self.server.memory);
        }
    }

    /// What is out of its range now.
    fn present(&self) -> i32 {
        let (voltage, temperature) = self.motor.supply_and_temperature();
        Control::out_of_range(&self.server.memory, voltage, temperature)
    }

    pub(super) fn publish(&mut self) {
        let sensed = self.motor.sensed();
        let (voltage, temperature) = self.motor.supply_and_temperature();
        let measured = Measured {
            shaft: sensed.position,
            rate: sensed.rate.round() as i32,
            load_permille: (sensed.duty * 1000.0).round() as i32,
            voltage,
            temperature,
            current: (sensed.current_a / self.current_unit_a).round() as i32,
            status: self.latched | self.present(),
            is_under_way: self.ramp.position() != self.control.goal,
        };
        self.control.report(&mut self.server.memory, &measured);
    }
}
