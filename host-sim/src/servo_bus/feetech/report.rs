//! Protections, and what the table reports.

use servo_bus::tables::sts;

use super::{OVERLOAD, SPEED_UNIT, Sts};

/// Further bits of the status.
const VOLTAGE: i32 = 1;
const TEMPERATURE: i32 = 4;
const CURRENT: i32 = 8;

impl Sts {
    pub(super) fn protect(&mut self) {
        let sensed = *self.motor.sensed();
        let acts = self.get(sts::UNLOADING_CONDITION);
        let overload = f64::from(self.get(sts::OVERLOAD_TORQUE)) / 100.0;
        let is_overloaded = self.latched & OVERLOAD == 0
            && sensed.duty.abs() > overload
            && sensed.rate.abs() < 50.0;
        if self
            .overload
            .exceeds(is_overloaded, 10 * self.get(sts::PROTECTION_TIME))
        {
            self.latched |= OVERLOAD & acts;
        }
        let most_a = f64::from(self.get(sts::PROTECTION_CURRENT)) * self.current_unit_a;
        let is_high = most_a > 0.0 && sensed.current_a.abs() > most_a;
        if self
            .overcurrent
            .exceeds(is_high, 10 * self.get(sts::OVERCURRENT_TIME))
        {
            self.latched |= CURRENT & acts;
        }
        let is_hot = sensed.temperature_c > f64::from(self.get(sts::MAX_TEMPERATURE_LIMIT));
        let volts = sensed.supply_v * 10.0;
        let (low, high) = (
            self.get(sts::MIN_VOLTAGE_LIMIT),
            self.get(sts::MAX_VOLTAGE_LIMIT),
        );
        let is_out = volts < f64::from(low) || volts > f64::from(high);
        let present = if is_hot { TEMPERATURE } else { 0 } | if is_out { VOLTAGE } else { 0 };
        self.set(sts::STATUS, self.latched | present);
        let ends = CURRENT & self.latched | (TEMPERATURE | VOLTAGE) & present & acts;
        if ends != 0 && self.torque != 0 {
            self.torque = 0;
            self.set(sts::TORQUE_ENABLE, 0);
        }
    }

    pub(super) fn publish(&mut self) {
        let sensed = *self.motor.sensed();
        let position = if self.mode == 3 {
            self.goal.wrapping_sub(self.position())
        } else {
            self.position()
        };
        self.set(sts::PRESENT_POSITION, position.clamp(-32_767, 32_767));
        self.set(
            sts::PRESENT_VELOCITY,
            (sensed.rate.round() as i32).clamp(-32_767, 32_767),
        );
        self.set(sts::PRESENT_LOAD, (sensed.duty * 1000.0).round() as i32);
        self.set(
            sts::PRESENT_VOLTAGE,
            ((sensed.supply_v * 10.0).round() as i32).clamp(0, 255),
        );
        self.set(
            sts::PRESENT_TEMPERATURE,
            (sensed.temperature_c.round() as i32).clamp(0, 255),
        );
        self.set(
            sts::PRESENT_CURRENT,
            (sensed.current_a / self.current_unit_a).round() as i32,
        );
        self.set(
            sts::GOAL_POSITION_IN_EFFECT,
            self.goal.clamp(-32_767, 32_767),
        );
        let is_under_way =
            self.torque == 1 && matches!(self.mode, 0 | 3) && self.ramp.position() != self.goal;
        let threshold = SPEED_UNIT * self.get(sts::MOVING_THRESHOLD);
        let is_moving = is_under_way || sensed.rate.abs() > f64::from(threshold);
        self.set(sts::MOVING, i32::from(is_moving));
    }
}
