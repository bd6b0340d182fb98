//! Protections, and what the table reports.

use servo_bus::tables::x;

use super::{FULL_PWM, VELOCITY_UNIT, X};

/// Bits of the hardware errors.
const VOLTAGE: i32 = 1;
const TEMPERATURE: i32 = 4;
const OVERLOAD: i32 = 32;

/// Output from which an overload counts, and for how long, ms.
const OVERLOAD_DUTY: f64 = 0.8;
const OVERLOAD_MS: i32 = 1000;

/// Deviation within which a goal is reached, steps.
const IN_POSITION: i32 = 10;

impl X {
    pub(super) fn protect(&mut self) {
        let sensed = *self.motor.sensed();
        let volts = sensed.supply_v * 10.0;
        let is_out =
            volts < self.real(x::MIN_VOLTAGE_LIMIT) || volts > self.real(x::MAX_VOLTAGE_LIMIT);
        let is_hot = sensed.temperature_c > self.real(x::TEMPERATURE_LIMIT);
        let is_at_rest = sensed.rate.abs() < self.real(x::MOVING_THRESHOLD) * VELOCITY_UNIT;
        let is_loaded = sensed.duty.abs() >= OVERLOAD_DUTY && is_at_rest;
        self.overload_ms = if is_loaded {
            self.overload_ms.saturating_add(1)
        } else {
            0
        };
        let bits = [
            (is_out, VOLTAGE),
            (is_hot, TEMPERATURE),
            (self.overload_ms > OVERLOAD_MS, OVERLOAD),
        ];
        let present = bits
            .iter()
            .filter(|(is_set, _)| *is_set)
            .fold(0, |all, (_, bit)| all | bit);
        let errors = self.get(x::HARDWARE_ERROR_STATUS) | present;
        self.set(x::HARDWARE_ERROR_STATUS, errors);
        if errors & self.get(x::SHUTDOWN) != 0 {
            self.set(x::TORQUE_ENABLE, 0);
            self.is_driven = false;
        }
    }

    pub(super) fn publish(&mut self) {
        let (sensed, position, forward) = (
            *self.motor.sensed(),
            self.position(),
            f64::from(self.direction()),
        );
        let rate = (self.rate() / VELOCITY_UNIT).round() as i32;
        self.set(x::PRESENT_POSITION, position);
        self.set(x::PRESENT_VELOCITY, rate);
        self.set(
            x::PRESENT_PWM,
            (forward * sensed.duty * FULL_PWM).round() as i32,
        );
        let current = (forward * sensed.current_a / self.current_unit_a).round() as i32;
        self.set(x::PRESENT_CURRENT, current.clamp(-32_768, 32_767));
        self.set(
            x::PRESENT_INPUT_VOLTAGE,
            ((sensed.supply_v * 10.0).round() as i32).clamp(0, 65_535),
        );
        self.set(
            x::PRESENT_TEMPERATURE,
            (sensed.temperature_c.round() as i32).clamp(0, 255),
        );
        self.set(x::REALTIME_TICK, self.time_ms);
        self.set(
            x::MOVING,
            i32::from(rate.abs() > self.get(x::MOVING_THRESHOLD)),
        );
        self.set(x::POSITION_TRAJECTORY, self.ramp.position());
        self.set(
            x::VELOCITY_TRAJECTORY,
            (f64::from(self.ramp.velocity()) / VELOCITY_UNIT).round() as i32,
        );
        let goal = self.get(x::GOAL_POSITION);
        let is_there = position.abs_diff(goal) <= IN_POSITION as u32;
        let is_under_way = self.is_driven && self.ramp.position() != goal;
        self.set(
            x::MOVING_STATUS,
            i32::from(is_there) | i32::from(is_under_way) << 1,
        );
    }
}
