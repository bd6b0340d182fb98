//! From goals to the bridge.

use canopen::cia402::{Limits, Ramp};
use servo_bus::tables::x;

use super::super::motor::{Drive, TURN};
use super::{
    CURRENT_MODE, CURRENT_POSITION_MODE, FULL_PWM, PWM_MODE, VELOCITY_MODE, VELOCITY_UNIT, X,
};

const PERIOD_US: u32 = 1000;

/// Acceleration of one, 214.577 rev/min^2, in steps/s^2.
const ACCELERATION_UNIT: f64 = 214.577 * TURN as f64 / 3600.0;

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
        let duty = match self.mode {
            PWM_MODE => self.real(x::GOAL_PWM) / FULL_PWM,
            CURRENT_MODE => {
                return Drive::Current(forward * most_current * self.current_unit_a, most);
            }
            VELOCITY_MODE => self.velocity_duty(),
            mode => {
                let output = self.position_output();
                if mode == CURRENT_POSITION_MODE {
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
            Some(limits) => drop(self.ramp.to_position(goal, &limits, PERIOD_US)),
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

    /// Limits of the way to the goal; `None` without a profile.
    pub(super) fn profile(&self) -> Option<Limits> {
        let (velocity, acceleration) = (
            self.real(x::PROFILE_VELOCITY),
            self.real(x::PROFILE_ACCELERATION),
        );
        let is_timed = self.get(x::DRIVE_MODE) & 4 != 0;
        let (velocity, acceleration) = match (self.mode, is_timed) {
            (VELOCITY_MODE, false) => (f64::INFINITY, acceleration * ACCELERATION_UNIT),
            (VELOCITY_MODE, true) => {
                let change = self.goal_velocity().abs_diff(self.ramp.velocity());
                (f64::INFINITY, rate(change.into(), acceleration))
            }
            _ if velocity == 0.0 => return None,
            (_, false) => (velocity * VELOCITY_UNIT, acceleration * ACCELERATION_UNIT),
            (_, true) => self.timed(velocity, acceleration),
        };
        // A fraction of a limit does not end the motion.
        let acceleration = if acceleration == 0.0 {
            u32::MAX
        } else {
            acceleration.ceil().max(1.0) as u32
        };
        Some(Limits {
            velocity: velocity.ceil().max(1.0) as u32,
            acceleration,
            deceleration: acceleration,
        })
    }

    /// Greatest velocity and acceleration of a motion from rest that lasts a time and accelerates
    /// for another one, at most half of it, ms.
    fn timed(&self, time_ms: f64, acceleration_ms: f64) -> (f64, f64) {
        let way = self.ramp.position().abs_diff(self.get(x::GOAL_POSITION));
        let ramp_ms = acceleration_ms.min(time_ms / 2.0);
        let velocity = rate(way.into(), time_ms - ramp_ms);
        (velocity, rate(velocity, ramp_ms))
    }

    /// Steps/s.
    fn goal_velocity(&self) -> i32 {
        (self.real(x::GOAL_VELOCITY) * VELOCITY_UNIT).round() as i32
    }

    /// Duty of the PI on the velocity.
    fn velocity_duty(&mut self) -> f64 {
        let limits = self.limits.unwrap_or(UNLIMITED);
        self.ramp
            .to_velocity(self.goal_velocity(), &limits, PERIOD_US);
        let error = (f64::from(self.ramp.velocity()) - self.rate()) / VELOCITY_UNIT;
        let i = self.real(x::VELOCITY_I_GAIN) / 65_536.0;
        self.sum = (self.sum + i * error).clamp(-FULL_PWM, FULL_PWM);
        (self.real(x::VELOCITY_P_GAIN) / 128.0 * error + self.sum) / FULL_PWM
    }
}

/// A change in a time, per s; 0 without a time.
fn rate(change: f64, ms: f64) -> f64 {
    if ms > 0.0 { change / ms * 1e3 } else { 0.0 }
}
