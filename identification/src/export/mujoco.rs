//! MuJoCo's `<position>` and `<dcmotor>` with the integrator `implicitfast`.

use std::sync::Arc;

use super::joint::Joint;
use super::law::{Law, Step, Stepped, TargetParameters};
use super::{About, Effect, Fitted, Target, number};
use crate::model::{Model, parameters};
use crate::scalar::Scalar;
use crate::start::DataSummary;

/// `<position>` at a joint.
pub struct Position;

/// `<dcmotor>` with a controller of its position.
pub struct DcMotor;

parameters! {
    /// What is fitted of `<position>` and its joint.
    pub struct PositionValues {
        stiffness_nm_rad: TargetParameters;
        rate_feedback_nm_s_rad: TargetParameters;
        damping_nm_s_rad: TargetParameters;
        torque_limit_nm: TargetParameters;
        friction_nm: TargetParameters;
        delay_steps: TargetParameters;
    }
}

parameters! {
    /// The same without damping of the actuator.
    pub struct JointDampingValues {
        stiffness_nm_rad: TargetParameters;
        damping_nm_s_rad: TargetParameters;
        torque_limit_nm: TargetParameters;
        friction_nm: TargetParameters;
        delay_steps: TargetParameters;
    }
}

parameters! {
    /// What is fitted of `<dcmotor>` and its joint.
    pub struct DcMotorValues {
        stiffness_nm_rad: TargetParameters;
        rate_feedback_nm_s_rad: TargetParameters;
        torque_limit_nm: TargetParameters;
        back_emf_nm_s_rad: TargetParameters;
        slew_rad_s: TargetParameters;
        friction_nm: TargetParameters;
        delay_steps: TargetParameters;
    }
}

/// The law of a position loop at a joint of this inertia.
#[derive(Clone, Copy)]
struct PositionLaw {
    inertia_kg_m2: f64,
    is_limit_of_joint: bool,
}

/// [`PositionLaw`] without `kv`: all damping is in the joint. The response of a rate-limited model
/// determines only the sum of both dampings, and a fit with both of them ends at a stiffness and a
/// torque that are a hundred times too high.
#[derive(Clone, Copy)]
struct JointDampingLaw(PositionLaw);

/// The laws of a position loop at a joint, simplest first.
pub(super) fn position_laws(
    about: &About,
    setpoint_deg: &Arc<[f64]>,
    is_limit_of_joint: bool,
) -> Vec<Arc<dyn Model>> {
    let law = PositionLaw {
        inertia_kg_m2: about.inertia_kg_m2,
        is_limit_of_joint,
    };
    vec![
        Arc::new(Stepped::new(JointDampingLaw(law), about, setpoint_deg)),
        Arc::new(Stepped::new(law, about, setpoint_deg)),
    ]
}

/// The damping of the actuator, Nm s/rad; zero in the law without one.
pub(super) fn rate_feedback(fitted: &Fitted) -> f64 {
    fitted.found("rate_feedback_nm_s_rad").unwrap_or(0.0)
}

#[derive(Clone, Copy)]
struct DcMotorLaw {
    inertia_kg_m2: f64,
}

/// Stiffness and damping of a joint whose lag is that of a response.
pub(super) fn oscillator(inertia_kg_m2: f64, data: &DataSummary) -> (f64, f64) {
    let frequency = data.natural_frequency_rad_s;
    let damping = 2.0 * data.damping * frequency * inertia_kg_m2;
    (inertia_kg_m2 * frequency * frequency, damping)
}

/// The steeper rate of a response, rad/s.
pub(super) fn fastest_rad_s(data: &DataSummary) -> f64 {
    let fastest = data.rate_up_deg_s.max(data.rate_down_deg_s);
    fastest.max(1.0).to_radians()
}

impl PositionLaw {
    /// The joint without damping and friction.
    fn joint<S: Scalar>(&self, step_s: f64, stiffness: S, torque_limit: S) -> Joint<S> {
        Joint {
            is_limit_of_joint: self.is_limit_of_joint,
            ..Joint::new(step_s, self.inertia_kg_m2, stiffness, torque_limit)
        }
    }
}

impl Law for PositionLaw {
    type Values<S: Scalar> = PositionValues<S>;

    fn start(&self, data: &DataSummary, step_s: f64) -> PositionValues<f64> {
        let (stiffness_nm_rad, damping) = oscillator(self.inertia_kg_m2, data);
        PositionValues {
            stiffness_nm_rad,
            rate_feedback_nm_s_rad: 0.1 * damping,
            damping_nm_s_rad: damping,
            torque_limit_nm: damping * fastest_rad_s(data),
            friction_nm: 0.0,
            delay_steps: data.second_order_delay_s / step_s,
        }
    }

    fn at_rest<S: Scalar>(&self, p: &PositionValues<S>, step_s: f64) -> impl Step<S> {
        Joint {
            rate_feedback: p.rate_feedback_nm_s_rad,
            damping: p.damping_nm_s_rad,
            friction: Some(p.friction_nm),
            ..self.joint(step_s, p.stiffness_nm_rad, p.torque_limit_nm)
        }
    }

    fn delay_steps<S: Scalar>(p: &PositionValues<S>) -> S {
        p.delay_steps
    }
}

impl Law for JointDampingLaw {
    type Values<S: Scalar> = JointDampingValues<S>;

    fn start(&self, data: &DataSummary, step_s: f64) -> JointDampingValues<f64> {
        let both = self.0.start(data, step_s);
        JointDampingValues {
            stiffness_nm_rad: both.stiffness_nm_rad,
            damping_nm_s_rad: both.damping_nm_s_rad,
            torque_limit_nm: both.torque_limit_nm,
            friction_nm: both.friction_nm,
            delay_steps: both.delay_steps,
        }
    }

    fn at_rest<S: Scalar>(&self, p: &JointDampingValues<S>, step_s: f64) -> impl Step<S> {
        Joint {
            damping: p.damping_nm_s_rad,
            friction: Some(p.friction_nm),
            ..(self.0).joint(step_s, p.stiffness_nm_rad, p.torque_limit_nm)
        }
    }

    fn delay_steps<S: Scalar>(p: &JointDampingValues<S>) -> S {
        p.delay_steps
    }
}

impl Law for DcMotorLaw {
    type Values<S: Scalar> = DcMotorValues<S>;

    fn start(&self, data: &DataSummary, step_s: f64) -> DcMotorValues<f64> {
        let (stiffness_nm_rad, damping) = oscillator(self.inertia_kg_m2, data);
        DcMotorValues {
            stiffness_nm_rad,
            rate_feedback_nm_s_rad: damping,
            torque_limit_nm: damping * fastest_rad_s(data),
            back_emf_nm_s_rad: damping,
            slew_rad_s: 2.0 * fastest_rad_s(data),
            friction_nm: 0.0,
            delay_steps: data.second_order_delay_s / step_s,
        }
    }

    fn at_rest<S: Scalar>(&self, p: &DcMotorValues<S>, step_s: f64) -> impl Step<S> {
        Joint {
            rate_feedback: p.rate_feedback_nm_s_rad,
            back_emf: p.back_emf_nm_s_rad,
            slew: Some(p.slew_rad_s),
            friction: Some(p.friction_nm),
            ..Joint::new(
                step_s,
                self.inertia_kg_m2,
                p.stiffness_nm_rad,
                p.torque_limit_nm,
            )
        }
    }

    fn delay_steps<S: Scalar>(p: &DcMotorValues<S>) -> S {
        p.delay_steps
    }
}

/// The whole model: a joint to be copied, and the actuator at it.
fn file(fitted: &Fitted, damping: f64, actuator: &str) -> String {
    let step = number(fitted.about.step_s);
    let armature = number(fitted.about.inertia_kg_m2);
    let (damping, friction) = (number(damping), number(fitted.value("friction_nm")));
    let delay = match fitted.delay_steps() {
        0 => String::new(),
        // Half a step less, so that rounding does not select the sample before.
        steps => format!(
            " delay=\"{}\" nsample=\"{}\"",
            number((f64::from(steps) - 0.5) * fitted.about.step_s),
            steps + 1
        ),
    };
    format!(
        "<mujoco>\nCOMMENT\n  <option timestep=\"{step}\" integrator=\"implicitfast\"/>\n  \
         <worldbody>\n    <body>\n      <joint name=\"joint\" axis=\"0 0 1\" armature=\"{armature}\" \
         damping=\"{damping}\" frictionloss=\"{friction}\"/>\n      \
         <inertial pos=\"0 0 0\" mass=\"1e-6\" diaginertia=\"1e-9 1e-9 1e-9\"/>\n    \
         </body>\n  </worldbody>\n  <actuator>\n    {actuator}{delay}/>\n  </actuator>\n</mujoco>\n"
    )
}

const KEPT: [Effect; 4] = [
    Effect::Torque,
    Effect::Delay,
    Effect::Limit,
    Effect::Friction,
];

impl Target for Position {
    fn name(&self) -> &'static str {
        "mujoco-position"
    }

    fn summary(&self) -> &'static str {
        "MuJoCo's position actuator and its joint"
    }

    fn step_s(&self) -> f64 {
        0.002
    }

    fn kept(&self) -> &'static [Effect] {
        &KEPT
    }

    fn comment(&self) -> (&'static str, &'static str) {
        ("  <!-- ", " -->")
    }

    fn laws(&self, about: &About, setpoint_deg: &Arc<[f64]>) -> Vec<Arc<dyn Model>> {
        position_laws(about, setpoint_deg, false)
    }

    fn body(&self, fitted: &Fitted) -> String {
        let limit = number(fitted.value("torque_limit_nm"));
        let actuator = format!(
            "<position name=\"servo\" joint=\"joint\" kp=\"{}\" kv=\"{}\" \
             forcerange=\"-{limit} {limit}\"",
            number(fitted.value("stiffness_nm_rad")),
            number(rate_feedback(fitted)),
        );
        file(fitted, fitted.value("damping_nm_s_rad"), &actuator)
    }
}

impl Target for DcMotor {
    fn name(&self) -> &'static str {
        "mujoco-dcmotor"
    }

    fn summary(&self) -> &'static str {
        "MuJoCo's DC motor with its controller, and its joint"
    }

    fn step_s(&self) -> f64 {
        Position.step_s()
    }

    fn kept(&self) -> &'static [Effect] {
        &KEPT
    }

    fn comment(&self) -> (&'static str, &'static str) {
        Position.comment()
    }

    fn laws(&self, about: &About, setpoint_deg: &Arc<[f64]>) -> Vec<Arc<dyn Model>> {
        let law = DcMotorLaw {
            inertia_kg_m2: about.inertia_kg_m2,
        };
        vec![Arc::new(Stepped::new(law, about, setpoint_deg))]
    }

    fn body(&self, fitted: &Fitted) -> String {
        // The limit is K/R (Vmax - K w).
        let resistance = fitted.about.resistance_ohm;
        let constant = (fitted.value("back_emf_nm_s_rad") * resistance).sqrt();
        let greatest_v = fitted.value("torque_limit_nm") * resistance / constant;
        let actuator = format!(
            "<dcmotor name=\"servo\" joint=\"joint\" input=\"pos\" motorconst=\"{}\" \
             resistance=\"{}\" controller=\"{} 0 {} {} 0 {}\"",
            number(constant),
            number(resistance),
            number(fitted.value("stiffness_nm_rad")),
            number(fitted.value("rate_feedback_nm_s_rad")),
            number(fitted.value("slew_rad_s")),
            number(greatest_v),
        );
        file(fitted, 0.0, &actuator)
    }
}
