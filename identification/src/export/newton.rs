//! A joint of Newton with the solver `SolverMuJoCo`, whose law is that of MuJoCo's `<position>`
//! with the limit at the joint.

use std::sync::Arc;

use super::{About, Effect, Fitted, Target, mujoco, number};
use crate::model::Model;

/// A joint of Newton.
pub struct Newton;

impl Target for Newton {
    fn name(&self) -> &'static str {
        "newton"
    }

    fn summary(&self) -> &'static str {
        "Newton's joint with SolverMuJoCo"
    }

    fn step_s(&self) -> f64 {
        mujoco::Position.step_s()
    }

    fn kept(&self) -> &'static [Effect] {
        &[
            Effect::Torque,
            Effect::Delay,
            Effect::Limit,
            Effect::Friction,
        ]
    }

    fn comment(&self) -> (&'static str, &'static str) {
        ("# ", "")
    }

    fn laws(&self, about: &About, setpoint_deg: &Arc<[f64]>) -> Vec<Arc<dyn Model>> {
        mujoco::position_laws(about, setpoint_deg, true)
    }

    fn body(&self, fitted: &Fitted) -> String {
        let values = [
            ("target_ke", fitted.value("stiffness_nm_rad")),
            ("target_kd", mujoco::rate_feedback(fitted)),
            ("damping", fitted.value("damping_nm_s_rad")),
            ("effort_limit", fitted.value("torque_limit_nm")),
            ("friction", fitted.value("friction_nm")),
            ("armature", fitted.about.inertia_kg_m2),
        ];
        let mut text =
            String::from("COMMENT\n# builder.add_joint_revolute(..., **SERVO)\nSERVO = {\n");
        for (name, value) in values {
            text += &format!("    \"{name}\": {},\n", number(value));
        }
        let delay = fitted.delay_steps();
        text + &format!(
            "}}\n# Newton has no delay: targets are set this number of steps later.\nDELAY_STEPS = {delay}\n"
        )
    }
}
