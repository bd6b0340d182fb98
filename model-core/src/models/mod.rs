//! The paper's three actuator models, in `f64`.
//!
//! Each is a set of parameters, checked once by its `try_new`, and a state that starts at rest at
//! zero. A model moves by whole ticks of 50 us ([`crate::time`]) with the command held; the
//! transport delay of the set-up stands in front of it, in a [`delay::DelayLine`].
//!
//! No command makes a model panic. A tick that would end in anything but finite numbers, as under
//! a NaN command, is not taken: the state stays as it was ([`rk4::step`]).

pub mod black_box_1;
pub mod black_box_2;
pub mod delay;
pub mod grey_box;
pub mod rk4;

#[cfg(test)]
mod tests;

crate::parameters! {
    /// What the test set-up does to a command on its way to the actuator.
    pub struct SetupParameters {
        /// Transport delay of the command, outside every loop.
        delay_s [""]: 0.0175, "s", 0.0, 1.0, "paper, section III: 0.0175 seconds";
        /// Period at which the host samples the command; 0 passes it on at every tick.
        host_period_s [""]: 0.0, "s", 0.0, 1.0, "the paper's host runs at 0.02 s";
    }
}

/// What a model shows at the instant of a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Output {
    /// Angle of the output shaft, deg.
    pub angle_deg: f64,
    /// Its rate, deg/s.
    pub rate_deg_s: f64,
    /// Duty at the motor, %; 0 for a model that has none.
    pub duty_pct: f64,
}

/// An actuator that is told an angle and moves toward it.
pub trait ActuatorModel {
    /// What is seen now, before the step, with `command_deg` at the input.
    ///
    /// Rate and duty may depend on the command directly, and are NaN under a NaN command then.
    fn output(&self, command_deg: f64) -> Output;

    /// Moves through one tick with `command_deg` held.
    fn step(&mut self, command_deg: f64);
}
