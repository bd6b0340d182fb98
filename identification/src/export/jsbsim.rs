//! JSBSim's `<actuator>`: a lag by Tustin's rule, then limits of the rate, then a delay.

use std::sync::Arc;

use super::law::{Law, Step, Stepped, TargetParameters};
use super::{About, Effect, Fitted, Target, number};
use crate::model::{Model, parameters};
use crate::scalar::Scalar;
use crate::start::DataSummary;

/// `<actuator>`.
pub struct JsbSim;

parameters! {
    /// What is fitted.
    pub struct JsbSimValues {
        lag_rad_s: TargetParameters;
        rate_up_deg_s: TargetParameters;
        rate_down_deg_s: TargetParameters;
        delay_steps: TargetParameters;
    }
}

#[derive(Clone, Copy)]
struct Lag;

struct State<S> {
    step_s: f64,
    p: JsbSimValues<S>,
    input: S,
    lagged: S,
    angle: S,
}

impl<S: Scalar> Step<S> for State<S> {
    fn step(&mut self, command_deg: S) -> S {
        let share = self.p.lag_rad_s * self.step_s;
        let scale = share + 2.0;
        let sum = command_deg + self.input;
        self.lagged = (share * sum + (-share + 2.0) * self.lagged) / scale;
        self.input = command_deg;
        let change = self.lagged - self.angle;
        let (up, down) = (self.p.rate_up_deg_s, self.p.rate_down_deg_s);
        self.angle = self.angle + change.within(-down * self.step_s, up * self.step_s);
        self.angle
    }
}

impl Law for Lag {
    type Values<S: Scalar> = JsbSimValues<S>;

    fn start(&self, data: &DataSummary, step_s: f64) -> JsbSimValues<f64> {
        JsbSimValues {
            lag_rad_s: data.pole_rad_s,
            rate_up_deg_s: data.rate_up_deg_s.max(1.0),
            rate_down_deg_s: data.rate_down_deg_s.max(1.0),
            delay_steps: data.delay_s / step_s,
        }
    }

    fn at_rest<S: Scalar>(&self, p: &JsbSimValues<S>, step_s: f64) -> impl Step<S> {
        let zero = S::constant(0.0);
        State {
            step_s,
            p: *p,
            input: zero,
            lagged: zero,
            angle: zero,
        }
    }

    fn delay_steps<S: Scalar>(p: &JsbSimValues<S>) -> S {
        p.delay_steps
    }
}

impl Target for JsbSim {
    fn name(&self) -> &'static str {
        "jsbsim"
    }

    fn summary(&self) -> &'static str {
        "JSBSim's actuator, in deg"
    }

    fn step_s(&self) -> f64 {
        1.0 / 120.0
    }

    fn kept(&self) -> &'static [Effect] {
        &[Effect::Delay, Effect::Limit, Effect::Direction]
    }

    fn comment(&self) -> (&'static str, &'static str) {
        ("  <!-- ", " -->")
    }

    fn laws(&self, about: &About, setpoint_deg: &Arc<[f64]>) -> Vec<Arc<dyn Model>> {
        vec![Arc::new(Stepped::new(Lag, about, setpoint_deg))]
    }

    fn body(&self, fitted: &Fitted) -> String {
        // Of n frames in its buffer, the oldest is n - 1 frames old.
        let delay = match fitted.delay_steps() {
            0 => String::new(),
            steps => format!("      <delay type=\"frames\">{}</delay>\n", steps + 1),
        };
        format!(
            "<system name=\"servo\">\nCOMMENT\n  <property value=\"0\">servo/command-deg</property>\n  \
             <property value=\"0\">servo/angle-deg</property>\n  <channel name=\"servo\">\n    \
             <actuator name=\"servo\">\n      <input>servo/command-deg</input>\n      \
             <lag>{}</lag>\n      <rate_limit sense=\"incr\">{}</rate_limit>\n      \
             <rate_limit sense=\"decr\">{}</rate_limit>\n{delay}      \
             <output>servo/angle-deg</output>\n    </actuator>\n  </channel>\n</system>\n",
            number(fitted.value("lag_rad_s")),
            number(fitted.value("rate_up_deg_s")),
            number(fitted.value("rate_down_deg_s")),
        )
    }
}
