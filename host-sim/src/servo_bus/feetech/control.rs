//! From goals to the bridge.

use canopen::cia402::Limits;
use servo_bus::feetech::{Control, mode, status};
use servo_bus::tables::sts;

use super::super::motor::{Drive, PERIOD_S};
use super::Sts;

/// Duty of the wheel mode per step/s, and per step, and unit of the coefficient: both make the loop
/// of an STS3215 with the defaults of 10 and 10 settle in 0.2 s.
const WHEEL_P: f64 = 1e-5;
const WHEEL_I: f64 = 1e-3;

impl Sts {
    /// Limits of the trajectory to a goal.
    fn limits(&self) -> Limits {
        let profile = Control::profile(&self.server.memory);
        Limits {
            velocity: profile.velocity,
            acceleration: profile.acceleration,
            deceleration: profile.acceleration,
        }
    }

    pub(super) fn drive(&mut self) -> Drive {
        match self.control.torque {
            0 => return Drive::Free,
            1 => {}
            _ => return Drive::Brake,
        }
        let duty = match self.control.mode {
            mode::WHEEL => self.wheel(),
            mode::PWM => f64::from(self.get(sts::GOAL_TIME)) / 1000.0,
            _ => self.position_duty(),
        };
        let mut most = f64::from(self.get(sts::TORQUE_LIMIT)) / 1000.0;
        if self.latched & status::OVERLOAD != 0 {
            most = most.min(f64::from(self.get(sts::PROTECTIVE_TORQUE)) / 100.0);
        }
        Drive::Duty(duty.clamp(-most, most))
    }

    /// Duty of the position loop: P/4 and D/8 in 0.1 % per step and per step/ms, nothing within the
    /// dead zone, and at least the starting force outside of it.
    fn position_duty(&mut self) -> f64 {
        let limits = self.limits();
        self.ramp.to_position(self.control.goal, &limits);
        let error = self.ramp.position() - self.position();
        let change = error - std::mem::replace(&mut self.error, error);
        let dead_zone = if error > 0 {
            sts::CW_DEAD_ZONE
        } else {
            sts::CCW_DEAD_ZONE
        };
        if error.abs() <= self.get(dead_zone) {
            return 0.0;
        }
        let p = f64::from(self.get(sts::P_COEFFICIENT)) / 4.0 * f64::from(error);
        let d = f64::from(self.get(sts::D_COEFFICIENT)) / 8.0 * f64::from(change);
        let duty = self.loop_scale * (p + d) / 1000.0;
        let least = f64::from(self.get(sts::MINIMUM_STARTUP_FORCE)) / 1000.0;
        if duty == 0.0 {
            0.0
        } else {
            duty.signum() * duty.abs().max(least)
        }
    }

    /// Duty of the wheel mode: PI on the rate.
    fn wheel(&mut self) -> f64 {
        let goal = Control::speed(&self.server.memory);
        let limits = Limits {
            velocity: Control::greatest_speed(&self.server.memory) as u32,
            ..self.limits()
        };
        self.ramp.to_velocity(goal, &limits);
        let error = f64::from(self.ramp.velocity()) - self.motor.sensed().rate;
        let gain = f64::from(self.get(sts::VELOCITY_I_COEFFICIENT)) * WHEEL_I;
        self.wheel_duty = (self.wheel_duty + gain * error * PERIOD_S).clamp(-1.0, 1.0);
        f64::from(self.get(sts::VELOCITY_P_COEFFICIENT)) * WHEEL_P * error + self.wheel_duty
    }
}
