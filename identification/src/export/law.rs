//! A target's own update law as a model that can be fitted.
//!
//! The law is stepped at the period of the target, from rest at zero, and the samples are those of
//! the response to which it is fitted. Targets delay by whole steps; between them the search
//! interpolates, so that the delay has a derivative.

use std::sync::Arc;

use super::About;
use crate::experiment::Experiment;
use crate::hybrid::Output;
use crate::model::{ActiveLimit, Description, ModelParameter, ParameterValues};
use crate::models::Dynamics;
use crate::scalar::Scalar;
use crate::start::DataSummary;

model_core::parameters! {
    /// Parameters of actuators in simulators.
    pub struct TargetParameters {
        /// Torque per error of the angle.
        stiffness_nm_rad [""]: 10.0, "Nm/rad", 1e-6, 1e6, "none";
        /// Torque per rate within the limit of the torque.
        rate_feedback_nm_s_rad [""]: 0.1, "Nm s/rad", 1e-9, 1e6, "none";
        /// Torque per rate outside that limit.
        damping_nm_s_rad [""]: 0.1, "Nm s/rad", 1e-9, 1e6, "none";
        /// Greatest torque, at rest.
        torque_limit_nm [""]: 1.0, "Nm", 1e-6, 1e6, "none";
        /// Decrease of that limit with the rate.
        back_emf_nm_s_rad [""]: 0.1, "Nm s/rad", 1e-9, 1e6, "none";
        /// Torque of dry friction.
        friction_nm [""]: 0.0, "Nm", 0.0, 1e3, "none";
        /// Greatest rate of the setpoint.
        slew_rad_s [""]: 10.0, "rad/s", 1e-3, 1e5, "none";
        /// Greatest rate of the shaft.
        rate_limit_rad_s [""]: 10.0, "rad/s", 1e-3, 1e5, "none";
        /// Greatest rate upward of a lag or a slew limit.
        rate_up_deg_s [""]: 400.0, "deg/s", 0.1, 1e6, "none";
        /// Greatest rate downward.
        rate_down_deg_s [""]: 400.0, "deg/s", 0.1, 1e6, "none";
        /// Pole of a first-order lag.
        lag_rad_s [""]: 20.0, "rad/s", 0.05, 1e4, "none";
        /// Cut-off frequency of a second-order low-pass filter.
        cutoff_hz [""]: 5.0, "Hz", 0.05, 400.0, "none";
        /// Duty, 0 to 1, per error of the angle.
        duty_per_rad [""]: 5.0, "1/rad", 1e-3, 1e5, "none";
        /// Torque constant at the output shaft.
        torque_constant_nm_a [""]: 1.0, "Nm/A", 1e-4, 1e3, "none";
        /// Inertia at the output shaft.
        inertia_kg_m2 [""]: 1e-2, "kg m^2", 1e-7, 1e2, "none";
        /// Delay of the command.
        delay_steps [""]: 0.0, "steps", 0.0, 1000.0, "none";
    }
}

/// The state of an actuator in its simulator.
pub(super) trait Step<S> {
    /// The angle at an instant, deg, under the command that arrives at it, deg; the state is then
    /// that of the next instant.
    fn step(&mut self, command_deg: S) -> S;
}

/// The law of a target.
pub(super) trait Law: Clone + Send + Sync + 'static {
    /// What is fitted.
    type Values<S: Scalar>: ParameterValues<S>;

    /// Starting values for a response.
    fn start(&self, data: &DataSummary, step_s: f64) -> Self::Values<f64>;

    /// The actuator at rest at zero.
    fn at_rest<S: Scalar>(&self, p: &Self::Values<S>, step_s: f64) -> impl Step<S>;

    /// The delay of the command in steps.
    fn delay_steps<S: Scalar>(_p: &Self::Values<S>) -> S {
        S::constant(0.0)
    }
}

/// A law under the command of a response.
#[derive(Clone)]
pub(super) struct Stepped<L> {
    law: L,
    step_s: f64,
    command_deg: Arc<[f64]>,
}

impl<L: Law> Description for Stepped<L> {
    fn name(&self) -> &'static str {
        "export"
    }

    fn summary(&self) -> &'static str {
        "the update law of a simulator"
    }

    fn parameters(&self) -> &[ModelParameter] {
        <L::Values<f64> as ParameterValues<f64>>::TABLE
    }
}

impl<L: Law> Stepped<L> {
    /// A law under a setpoint for each step.
    pub fn new(law: L, about: &About, setpoint_deg: &Arc<[f64]>) -> Self {
        Self {
            law,
            step_s: about.step_s,
            command_deg: setpoint_deg.clone(),
        }
    }

    /// The command at a step that a delay has, which need not be a whole number of steps.
    fn delayed<S: Scalar>(&self, step: usize, delay: S) -> S {
        let whole = delay.value().floor().max(0.0);
        let at = |back: usize| self.command_deg[step.saturating_sub(back)];
        let (near, far) = (at(whole as usize), at(whole as usize + 1));
        (delay + -whole) * (far - near) + near
    }
}

impl<L: Law> Dynamics for Stepped<L> {
    type Parameters<S: Scalar> = L::Values<S>;

    fn start(&self, experiments: &[Experiment]) -> L::Values<f64> {
        self.law.start(&DataSummary::of(experiments), self.step_s)
    }

    fn run<S: Scalar>(&self, run: &Experiment, p: &L::Values<S>, output: &mut impl Output<S>) {
        let delay = L::delay_steps(p);
        let mut actuator = self.law.at_rest(p, self.step_s);
        let mut instants = run.time_ns.iter().enumerate().peekable();
        for step in 0..self.command_deg.len() {
            let angle = actuator.step(self.delayed(step, delay));
            let time_ns = (step as f64 * self.step_s * 1e9).round() as i64;
            if let Some((i, _)) = instants.next_if(|(_, instant)| **instant <= time_ns) {
                output.sample(i, angle, 0.0, ActiveLimit::Free);
            }
        }
    }
}
