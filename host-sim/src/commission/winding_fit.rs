//! Resistance and inductance of a winding from samples of its current, by least squares.

use super::regression::{Regression, regression};
use super::samples::Sample;
use super::winding::Winding;
use super::{CommissionError, Estimate, Step, refuse};

const STEP: Step = Step::Resistance;

/// Iterations of the search: each is a Gauss-Newton step of a smooth function of two parameters.
const ITERATIONS: usize = 30;

/// Largest step of the logarithm of a parameter.
const LARGEST: f64 = 0.5;

/// The winding of least squares, and its resistance with the standard error of the residuals.
pub fn fit(samples: &[Sample], start: &Winding) -> Result<(Winding, Estimate), CommissionError> {
    let mut winding = *start;
    let mut last = None;
    for _ in 0..ITERATIONS {
        last = linearised(samples, &winding);
        let steps = last.map_or([0.0; 2], |found| found.coefficients);
        winding = scaled(&winding, steps.map(|step| step.clamp(-LARGEST, LARGEST)));
    }
    let relative = last.map_or(f64::INFINITY, |found| found.estimate(0).standard_error);
    let resistance = Estimate {
        value: winding.resistance_ohm,
        standard_error: winding.resistance_ohm * relative,
    };
    if relative < 0.1 {
        return Ok((winding, resistance));
    }
    let why = format!(
        "the resistance cannot be identified: {:.3} ohm is uncertain by more than 10 %; expected a \
         larger --current",
        winding.resistance_ohm
    );
    refuse(STEP, why)
}

/// With logarithms that are so much greater, which keep both parameters positive.
fn scaled(winding: &Winding, [resistance, inductance]: [f64; 2]) -> Winding {
    Winding {
        resistance_ohm: winding.resistance_ohm * resistance.exp(),
        inductance_h: winding.inductance_h * inductance.exp(),
    }
}

/// The steps of both logarithms that explain what the samples differ from the model by.
fn linearised(samples: &[Sample], winding: &Winding) -> Option<Regression<2>> {
    const STEP: f64 = 1e-4;
    let others = [[STEP, 0.0], [0.0, STEP]].map(|steps| scaled(winding, steps));
    let rows = samples.iter().map(|sample| {
        let current = |winding: &Winding| winding.current(sample.driven).sampled_a;
        let here = current(winding);
        let slopes = others
            .each_ref()
            .map(|other| (current(other) - here) / STEP);
        (slopes, sample.sampled_a - here)
    });
    regression(&rows.collect::<Vec<_>>())
}
