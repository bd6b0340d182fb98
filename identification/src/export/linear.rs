//! Transfer functions: the linear part of a response, of first or second order, with a delay.

use std::sync::Arc;

use super::{About, Effect, Fitted, Target, number};
use crate::model::Model;
use crate::models::{BlackBox1, BlackBox2Oscillator};

/// A script of MATLAB or Octave.
pub struct Matlab;

/// A script for python-control.
pub struct PythonControl;

/// Numerator and denominator, highest power first.
fn polynomials(fitted: &Fitted) -> (String, String) {
    match fitted.found("pole_rad_s") {
        Some(pole) => (number(fitted.gain * pole), format!("[1, {}]", number(pole))),
        None => {
            let frequency = fitted.value("natural_frequency_rad_s");
            let square = frequency * frequency;
            let middle = 2.0 * fitted.value("damping") * frequency;
            (
                number(fitted.gain * square),
                format!("[1, {}, {}]", number(middle), number(square)),
            )
        }
    }
}

const KEPT: [Effect; 1] = [Effect::Delay];

/// The period of the samples that are compared, s; the model itself is continuous.
const STEP_S: f64 = 0.002;

fn forms() -> Vec<Arc<dyn Model>> {
    vec![Arc::new(BlackBox1), Arc::new(BlackBox2Oscillator)]
}

impl Target for Matlab {
    fn name(&self) -> &'static str {
        "matlab"
    }

    fn summary(&self) -> &'static str {
        "Transfer function for MATLAB"
    }

    fn step_s(&self) -> f64 {
        STEP_S
    }

    fn kept(&self) -> &'static [Effect] {
        &KEPT
    }

    fn comment(&self) -> (&'static str, &'static str) {
        ("% ", "")
    }

    fn laws(&self, _about: &About, _setpoint_deg: &Arc<[f64]>) -> Vec<Arc<dyn Model>> {
        forms()
    }

    fn body(&self, fitted: &Fitted) -> String {
        let (numerator, denominator) = polynomials(fitted);
        let delay = number(fitted.value("delay_s"));
        format!("COMMENT\nservo = tf({numerator}, {denominator}, 'InputDelay', {delay});\n")
    }
}

impl Target for PythonControl {
    fn name(&self) -> &'static str {
        "python-control"
    }

    fn summary(&self) -> &'static str {
        "Transfer function for python-control"
    }

    fn step_s(&self) -> f64 {
        STEP_S
    }

    fn kept(&self) -> &'static [Effect] {
        &KEPT
    }

    fn comment(&self) -> (&'static str, &'static str) {
        ("# ", "")
    }

    fn laws(&self, _about: &About, _setpoint_deg: &Arc<[f64]>) -> Vec<Arc<dyn Model>> {
        forms()
    }

    fn body(&self, fitted: &Fitted) -> String {
        let (numerator, denominator) = polynomials(fitted);
        let delay = number(fitted.value("delay_s"));
        format!(
            "COMMENT\nimport control\n\ndelay_s = {delay}\n\
             lag = control.tf([{numerator}], {denominator})\n\
             # python-control has no delay: an approximation of it.\n\
             servo = lag * control.tf(*control.pade(delay_s, 4)) if delay_s else lag\n"
        )
    }
}
