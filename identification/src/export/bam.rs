//! BAM's servo with a position loop and friction M1, in the form of its actuators of the series
//! Dynamixel MX.
//!
//! ```text
//! V = vin clip(error_gain kp (u - q))      M (w1 - w) = h (kt/R (V - kt w) - friction)
//! q1 = q + h w1 + (w1 - w) h / 2           friction at most friction_base + friction_viscous |w|
//! ```

use std::sync::Arc;

use super::law::{Law, Step, Stepped, TargetParameters};
use super::mujoco::fastest_rad_s;
use super::{About, Effect, Fitted, Target, number};
use crate::model::{Model, parameters};
use crate::scalar::Scalar;
use crate::start::DataSummary;

/// A servo of BAM.
pub struct Bam;

/// BAM's `error_gain` and `max_pwm` of its actuator `mx64`.
const ERROR_GAIN: f64 = 0.158;
const GREATEST_DUTY: f64 = 0.9625;

const DEGREE: f64 = std::f64::consts::PI / 180.0;

parameters! {
    /// What is fitted.
    pub struct BamValues {
        duty_per_rad: TargetParameters;
        torque_constant_nm_a: TargetParameters;
        inertia_kg_m2: TargetParameters;
        friction_nm: TargetParameters;
        damping_nm_s_rad: TargetParameters;
    }
}

#[derive(Clone, Copy)]
struct Servo {
    about: About,
}

struct State<S> {
    step_s: f64,
    about: About,
    p: BamValues<S>,
    angle: S,
    rate: S,
}

impl<S: Scalar> Step<S> for State<S> {
    fn step(&mut self, command_deg: S) -> S {
        let (p, before) = (&self.p, self.angle);
        let most = S::constant(GREATEST_DUTY);
        let duty = (command_deg * DEGREE - self.angle) * p.duty_per_rad;
        let volts = duty.within(-most, most) * self.about.supply_v;
        let constant = p.torque_constant_nm_a;
        let current = (volts - constant * self.rate) * (1.0 / self.about.resistance_ohm);
        let torque = constant * current;
        let stopping = p.inertia_kg_m2 * self.rate * (1.0 / self.step_s) + torque;
        let budget = p.friction_nm + p.damping_nm_s_rad * self.rate.abs();
        let net = torque - stopping.within(-budget, budget);
        let change = net * self.step_s / p.inertia_kg_m2;
        self.rate = self.rate + change;
        self.angle = self.angle + (self.rate + change * 0.5) * self.step_s;
        before * (1.0 / DEGREE)
    }
}

impl Law for Servo {
    type Values<S: Scalar> = BamValues<S>;

    fn start(&self, data: &DataSummary, _step_s: f64) -> BamValues<f64> {
        let About {
            resistance_ohm,
            supply_v,
            ..
        } = self.about;
        // The fastest rate is that without a load, and the lag is that of a servo without inertia.
        let constant = supply_v / fastest_rad_s(data);
        BamValues {
            duty_per_rad: data.pole_rad_s * constant / supply_v,
            torque_constant_nm_a: constant,
            inertia_kg_m2: constant * constant / resistance_ohm / (4.0 * data.pole_rad_s),
            friction_nm: 0.0,
            damping_nm_s_rad: 1e-3 * constant * constant / resistance_ohm,
        }
    }

    fn at_rest<S: Scalar>(&self, p: &BamValues<S>, step_s: f64) -> impl Step<S> {
        State {
            step_s,
            about: self.about,
            p: *p,
            angle: S::constant(0.0),
            rate: S::constant(0.0),
        }
    }
}

impl Target for Bam {
    fn name(&self) -> &'static str {
        "bam"
    }

    fn summary(&self) -> &'static str {
        "BAM's model M1 of a servo"
    }

    fn step_s(&self) -> f64 {
        0.002
    }

    fn kept(&self) -> &'static [Effect] {
        &[Effect::Torque, Effect::Limit, Effect::Friction]
    }

    fn comment(&self) -> (&'static str, &'static str) {
        ("    \"", "\",")
    }

    fn laws(&self, about: &About, setpoint_deg: &Arc<[f64]>) -> Vec<Arc<dyn Model>> {
        let law = Servo { about: *about };
        vec![Arc::new(Stepped::new(law, about, setpoint_deg))]
    }

    fn body(&self, fitted: &Fitted) -> String {
        format!(
            "{{\n  \"model\": \"m1\",\n  \"actuator\": \"mx64\",\n  \"kt\": {},\n  \"R\": {},\n  \
             \"armature\": {},\n  \"q_offset\": 0.0,\n  \"friction_base\": {},\n  \
             \"friction_viscous\": {},\n  \"kp\": {},\n  \"vin\": {},\n  \"comment\": [\nCOMMENT\n    \
             \"BAM takes kp and vin from a log, or from model.actuator.\"\n  ]\n}}\n",
            number(fitted.value("torque_constant_nm_a")),
            number(fitted.about.resistance_ohm),
            number(fitted.value("inertia_kg_m2")),
            number(fitted.value("friction_nm")),
            number(fitted.value("damping_nm_s_rad")),
            number(fitted.value("duty_per_rad") / ERROR_GAIN),
            number(fitted.about.supply_v),
        )
    }
}
