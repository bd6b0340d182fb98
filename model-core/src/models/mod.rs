//! The paper's three actuator models, in `f64`.
//!
//! Each model has a parameter set, checked once by its `try_new`, and a state that starts at rest
//! at zero. A model advances by whole ticks of 50 us ([`crate::time`]) with the command held; the
//! transport delay of the test set-up is outside the model, in a [`delay::DelayLine`].
//!
//! No command makes a model panic. If a tick would end in a state that is not finite, for example
//! with a NaN command, the state remains unchanged ([`rk4::step`]).

pub mod black_box_1;
pub mod black_box_2;
pub mod delay;
pub mod grey_box;
pub mod rk4;

#[cfg(test)]
mod tests;

crate::parameters! {
    /// Effect of the test set-up on a command.
    pub struct SetupParameters {
        /// Transport delay of the command, outside all loops.
        delay_s [""]: 0.0175, "s", 0.0, 1.0, "paper, section III: 0.0175 seconds";
        /// Sampling period of the host; 0 passes the command on at every tick.
        host_period_s [""]: 0.0, "s", 0.0, 1.0, "the paper's host runs at 0.02 s";
    }
}

/// Output of a model at a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Output {
    /// Angle of the output shaft, deg.
    pub angle_deg: f64,
    /// Rate of the output shaft, deg/s.
    pub rate_deg_s: f64,
    /// Duty at the motor, %; 0 for a model without a duty.
    pub duty_pct: f64,
}

/// A model of an actuator with position command.
pub trait ActuatorModel {
    /// The output before the step, with `command_deg` at the input.
    ///
    /// Rate and duty may depend directly on the command and are then NaN for a NaN command.
    fn output(&self, command_deg: f64) -> Output;

    /// Advances one tick with `command_deg` held.
    fn advance_tick(&mut self, command_deg: f64);
}
