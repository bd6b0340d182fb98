//! Gazebo's `JointPositionController` at a joint with damping, which DART takes implicitly.
//!
//! The controller has no derivative gain: it would act on the steps of the setpoint.

use std::sync::Arc;

use super::joint::Joint;
use super::law::{Law, Step, Stepped, TargetParameters};
use super::mujoco::{fastest_rad_s, oscillator};
use super::{About, Effect, Fitted, Target, number};
use crate::model::{Model, parameters};
use crate::scalar::Scalar;
use crate::start::DataSummary;

/// `JointPositionController`.
pub struct Gazebo;

parameters! {
    /// What is fitted.
    pub struct GazeboValues {
        stiffness_nm_rad: TargetParameters;
        damping_nm_s_rad: TargetParameters;
        torque_limit_nm: TargetParameters;
    }
}

#[derive(Clone, Copy)]
struct Controller {
    inertia_kg_m2: f64,
}

impl Law for Controller {
    type Values<S: Scalar> = GazeboValues<S>;

    fn start(&self, data: &DataSummary, _step_s: f64) -> GazeboValues<f64> {
        let (stiffness_nm_rad, damping_nm_s_rad) = oscillator(self.inertia_kg_m2, data);
        GazeboValues {
            stiffness_nm_rad,
            damping_nm_s_rad,
            torque_limit_nm: damping_nm_s_rad * fastest_rad_s(data),
        }
    }

    fn at_rest<S: Scalar>(&self, p: &GazeboValues<S>, step_s: f64) -> impl Step<S> {
        Joint {
            damping: p.damping_nm_s_rad,
            implicit: (true, false),
            ..Joint::new(
                step_s,
                self.inertia_kg_m2,
                p.stiffness_nm_rad,
                p.torque_limit_nm,
            )
        }
    }
}

impl Target for Gazebo {
    fn name(&self) -> &'static str {
        "gazebo"
    }

    fn summary(&self) -> &'static str {
        "Gazebo's JointPositionController, and the damping of its joint"
    }

    fn step_s(&self) -> f64 {
        0.001
    }

    fn kept(&self) -> &'static [Effect] {
        &[Effect::Torque, Effect::Limit]
    }

    fn comment(&self) -> (&'static str, &'static str) {
        ("  <!-- ", " -->")
    }

    fn laws(&self, about: &About, setpoint_deg: &Arc<[f64]>) -> Vec<Arc<dyn Model>> {
        let law = Controller {
            inertia_kg_m2: about.inertia_kg_m2,
        };
        vec![Arc::new(Stepped::new(law, about, setpoint_deg))]
    }

    fn body(&self, fitted: &Fitted) -> String {
        let limit = number(fitted.value("torque_limit_nm"));
        format!(
            "<sdf version=\"1.9\">\nCOMMENT\n  <!-- The link of the joint has {} kg m^2 more about the axis. -->\n  \
             <model name=\"servo\">\n    <joint name=\"joint\" type=\"revolute\">\n      <axis>\n        \
             <dynamics>\n          <damping>{}</damping>\n        </dynamics>\n      </axis>\n    \
             </joint>\n    <plugin filename=\"gz-sim-joint-position-controller-system\" \
             name=\"gz::sim::systems::JointPositionController\">\n      \
             <joint_name>joint</joint_name>\n      <p_gain>{}</p_gain>\n      <i_gain>0</i_gain>\n      \
             <d_gain>0</d_gain>\n      <cmd_max>{limit}</cmd_max>\n      \
             <cmd_min>-{limit}</cmd_min>\n    </plugin>\n  </model>\n</sdf>\n",
            number(fitted.about.inertia_kg_m2),
            number(fitted.value("damping_nm_s_rad")),
            number(fitted.value("stiffness_nm_rad")),
        )
    }
}
