//! Isaac Lab's `DelayedPDActuatorCfg`: an explicit loop, and PhysX with its limit of the rate.

use std::sync::Arc;

use super::joint::Joint;
use super::law::{Law, Step, Stepped, TargetParameters};
use super::mujoco::{fastest_rad_s, oscillator};
use super::{About, Effect, Fitted, Target, number};
use crate::model::{Model, parameters};
use crate::scalar::Scalar;
use crate::start::DataSummary;

/// `DelayedPDActuatorCfg`.
pub struct IsaacLab;

parameters! {
    /// What is fitted.
    pub struct IsaacLabValues {
        stiffness_nm_rad: TargetParameters;
        rate_feedback_nm_s_rad: TargetParameters;
        torque_limit_nm: TargetParameters;
        rate_limit_rad_s: TargetParameters;
        delay_steps: TargetParameters;
    }
}

#[derive(Clone, Copy)]
struct Loop {
    inertia_kg_m2: f64,
}

impl Law for Loop {
    type Values<S: Scalar> = IsaacLabValues<S>;

    fn start(&self, data: &DataSummary, step_s: f64) -> IsaacLabValues<f64> {
        let (stiffness_nm_rad, damping) = oscillator(self.inertia_kg_m2, data);
        // An explicit loop with more damping diverges.
        let stable = damping.min(self.inertia_kg_m2 / step_s);
        IsaacLabValues {
            stiffness_nm_rad,
            rate_feedback_nm_s_rad: stable,
            torque_limit_nm: 4.0 * damping * fastest_rad_s(data),
            rate_limit_rad_s: fastest_rad_s(data),
            delay_steps: data.second_order_delay_s / step_s,
        }
    }

    fn at_rest<S: Scalar>(&self, p: &IsaacLabValues<S>, step_s: f64) -> impl Step<S> {
        Joint {
            rate_feedback: p.rate_feedback_nm_s_rad,
            rate_limit: Some(p.rate_limit_rad_s),
            implicit: (false, false),
            ..Joint::new(
                step_s,
                self.inertia_kg_m2,
                p.stiffness_nm_rad,
                p.torque_limit_nm,
            )
        }
    }

    fn delay_steps<S: Scalar>(p: &IsaacLabValues<S>) -> S {
        p.delay_steps
    }
}

impl Target for IsaacLab {
    fn name(&self) -> &'static str {
        "isaaclab"
    }

    fn summary(&self) -> &'static str {
        "Isaac Lab's DelayedPDActuatorCfg"
    }

    fn step_s(&self) -> f64 {
        0.005
    }

    fn kept(&self) -> &'static [Effect] {
        &[Effect::Torque, Effect::Delay, Effect::Limit]
    }

    fn comment(&self) -> (&'static str, &'static str) {
        ("# ", "")
    }

    fn laws(&self, about: &About, setpoint_deg: &Arc<[f64]>) -> Vec<Arc<dyn Model>> {
        let law = Loop {
            inertia_kg_m2: about.inertia_kg_m2,
        };
        vec![Arc::new(Stepped::new(law, about, setpoint_deg))]
    }

    fn body(&self, fitted: &Fitted) -> String {
        format!(
            "COMMENT\nfrom isaaclab.actuators import DelayedPDActuatorCfg\n\nSERVO = DelayedPDActuatorCfg(\n    \
             joint_names_expr=[\".*\"],\n    stiffness={},\n    damping={},\n    effort_limit={},\n    \
             velocity_limit_sim={},\n    armature={},\n    min_delay={delay},\n    max_delay={delay},\n)\n",
            number(fitted.value("stiffness_nm_rad")),
            number(fitted.value("rate_feedback_nm_s_rad")),
            number(fitted.value("torque_limit_nm")),
            number(fitted.value("rate_limit_rad_s")),
            number(fitted.about.inertia_kg_m2),
            delay = fitted.delay_steps(),
        )
    }
}
