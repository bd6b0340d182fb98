//! From goals to the bridge.

use canopen::cia402::{Limits, Ramp};
use servo_bus::dynamixel::{Control, mode};
use servo_bus::tables::x;

use super::super::motor::Drive;
use super::{FULL_PWM, VELOCITY_UNIT, X};

const UNLIMITED: Limits = Limits {
    velocity: u32::MAX,
    acceleration: u32::MAX,
    deceleration: u32::MAX,
};

impl X {
    pub(super) fn drive(&mut self) -> Drive {
        let forward = f64::from(self.direction());
        let most = self.real(x::GOAL_PWM).abs() / FULL_PWM;
        let most_current = self.real(x::GOAL_CURRENT);
        let duty = match self.control.mode {
            mode::PWM => self.real(x::GOAL_PWM) / FULL_PWM,
            mode::CURRENT => {
                return Drive::Current(forward * most_current * self.current_unit_a, most);
            }
            mode::VELOCITY => self.velocity_duty(),
            of_position => {
                let output = self.position_output();
                if of_position == mode::CURRENT_BASED_POSITION {
                    let current = output.clamp(-most_current.abs(), most_current.abs());
                    return Drive::Current(forward * current * self.current_unit_a, most);
                }
                self.loop_scale * output / FULL_PWM
            }
        };
        Drive::Duty(forward * duty.clamp(-most, most))
    }

    /// Output of the PID on the position, in its units.
    fn position_output(&mut self) -> f64 {
        let goal = self.get(x::GOAL_POSITION);
        match self.limits {
            Some(limits) => drop(self.ramp.to_position(goal, &limits)),
            None => self.ramp = Ramp::at(goal),
        }
        let error = self.ramp.position().wrapping_sub(self.position());
        let change = error - std::mem::replace(&mut self.error, error);
        let gain = |field, share: f64| self.real(field) / share;
        let i = gain(x::POSITION_I_GAIN, 65_536.0);
        // Without effect above the range of the output.
        let sum = (self.sum + i * f64::from(error)).clamp(-FULL_PWM, FULL_PWM);
        let output = gain(x::POSITION_P_GAIN, 128.0) * f64::from(error)
            + sum
            + gain(x::POSITION_D_GAIN, 16.0) * f64::from(change);
        self.sum = sum;
        output
    }

    /// Duty of the PI on the velocity.
    fn velocity_duty(&mut self) -> f64 {
        let limits = self.limits.unwrap_or(UNLIMITED);
        let goal = Control::goal_velocity(&self.server.memory);
        self.ramp.to_velocity(goal, &limits);
        let error = (f64::from(self.ramp.velocity()) - self.rate()) / VELOCITY_UNIT;
        let i = self.real(x::VELOCITY_I_GAIN) / 65_536.0;
        self.sum = (self.sum + i * error).clamp(-FULL_PWM, FULL_PWM);
        (self.real(x::VELOCITY_P_GAIN) / 128.0 * error + self.sum) / FULL_PWM
    }
}
