//! The servo of ArduPilot's SITL: a delay, a slew limit, and a second-order Butterworth filter.

use std::f64::consts::PI;
use std::sync::Arc;

use super::law::{Law, Step, Stepped, TargetParameters};
use super::{About, Effect, Fitted, Target, number};
use crate::model::{Model, parameters};
use crate::scalar::Scalar;
use crate::start::DataSummary;

/// The parameters `SIM_SERVO_*`.
pub struct ArduPilot;

parameters! {
    /// What is fitted.
    pub struct ArduPilotValues {
        rate_up_deg_s: TargetParameters;
        cutoff_hz: TargetParameters;
        delay_steps: TargetParameters;
    }
}

#[derive(Clone, Copy)]
struct Servo;

struct State<S> {
    most: S,
    /// Coefficients of the filter: of the input, and of the two last states.
    b0: S,
    a1: S,
    a2: S,
    slewed: S,
    elements: [S; 2],
}

impl<S: Scalar> Step<S> for State<S> {
    fn step(&mut self, command_deg: S) -> S {
        let change = command_deg - self.slewed;
        self.slewed = self.slewed + change.within(-self.most, self.most);
        let [first, second] = self.elements;
        let element = self.slewed - first * self.a1 - second * self.a2;
        self.elements = [element, first];
        (element + first * 2.0 + second) * self.b0
    }
}

impl Law for Servo {
    type Values<S: Scalar> = ArduPilotValues<S>;

    fn start(&self, data: &DataSummary, step_s: f64) -> ArduPilotValues<f64> {
        ArduPilotValues {
            rate_up_deg_s: data.rate_up_deg_s.max(data.rate_down_deg_s).max(1.0),
            cutoff_hz: data.natural_frequency_rad_s / (2.0 * PI),
            delay_steps: data.second_order_delay_s / step_s,
        }
    }

    fn at_rest<S: Scalar>(&self, p: &ArduPilotValues<S>, step_s: f64) -> impl Step<S> {
        let one = S::constant(1.0);
        // tan(x) = sin(x) / sin(x + pi/2)
        let x = p.cutoff_hz * (PI * step_s);
        let ohm = x.sin() / (x + PI / 2.0).sin();
        let middle = ohm * (2.0 * (PI / 4.0).cos());
        let square = ohm * ohm;
        let scale = one / (square + middle + 1.0);
        State {
            most: p.rate_up_deg_s * step_s,
            b0: square * scale,
            a1: (square + -1.0) * scale * 2.0,
            a2: (square - middle + 1.0) * scale,
            slewed: S::constant(0.0),
            elements: [S::constant(0.0); 2],
        }
    }

    fn delay_steps<S: Scalar>(p: &ArduPilotValues<S>) -> S {
        p.delay_steps
    }
}

impl Target for ArduPilot {
    fn name(&self) -> &'static str {
        "ardupilot-sitl"
    }

    fn summary(&self) -> &'static str {
        "The servo model of ArduPilot's SITL, for all servos"
    }

    fn step_s(&self) -> f64 {
        1.0 / 1200.0
    }

    /// The rate is a whole number of Hz, and the period the whole number of us within its inverse.
    fn nearest_step_s(&self, step_s: f64) -> f64 {
        (1e6 / (1.0 / step_s).round()).floor() * 1e-6
    }

    fn kept(&self) -> &'static [Effect] {
        &[Effect::Delay, Effect::Limit]
    }

    fn comment(&self) -> (&'static str, &'static str) {
        ("# ", "")
    }

    fn laws(&self, about: &About, setpoint_deg: &Arc<[f64]>) -> Vec<Arc<dyn Model>> {
        vec![Arc::new(Stepped::new(Servo, about, setpoint_deg))]
    }

    fn body(&self, fitted: &Fitted) -> String {
        // Of n values in its buffer, the first one is n - 1 steps old; the number is truncated.
        let steps = f64::from(fitted.delay_steps());
        let delay_s = match steps {
            0.0 => 0.0,
            steps => (steps + 1.5) * fitted.about.step_s,
        };
        // The highest rate with this period.
        let rate_hz = (1.0 / fitted.about.step_s + 1e-6).floor();
        format!(
            "COMMENT\nSIM_RATE_HZ {}\nSIM_SERVO_SPEED {}\nSIM_SERVO_DELAY {}\nSIM_SERVO_FILTER {}\n",
            number(rate_hz),
            number(60.0 / fitted.value("rate_up_deg_s")),
            number(delay_s),
            number(fitted.value("cutoff_hz")),
        )
    }
}
