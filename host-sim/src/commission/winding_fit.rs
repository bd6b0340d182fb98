//! Resistance and inductance of a winding from samples of its current, by least squares.

use super::regression::inverse;
use super::samples::Sample;
use super::winding::Winding;
use super::{CommissionError, refuse};

const STEP: &str = "resistance";

/// Iterations of the search: each is a Newton step of a smooth function of two parameters.
const ITERATIONS: usize = 50;

/// Resistance and inductance of least squares, and their covariance by the residuals.
pub fn fit(
    samples: &[Sample],
    start: &Winding,
) -> Result<(Winding, [[f64; 2]; 2]), CommissionError> {
    // Logarithms, which keep both positive.
    let mut point = [start.resistance_ohm.ln(), start.inductance_h.ln()];
    let mut cost = squares(samples, point);
    let mut damping = 1e-3;
    for _ in 0..ITERATIONS {
        let (information, gradient) = normal(samples, point);
        let mut damped = information;
        damped[0][0] *= 1.0 + damping;
        damped[1][1] *= 1.0 + damping;
        let Some(inverse) = inverse(damped) else {
            break;
        };
        let step = [0, 1].map(|i| inverse[i][0] * gradient[0] + inverse[i][1] * gradient[1]);
        let trial = [
            point[0] - step[0].clamp(-1.0, 1.0),
            point[1] - step[1].clamp(-1.0, 1.0),
        ];
        let trial_cost = squares(samples, trial);
        if trial_cost < cost {
            (point, cost, damping) = (trial, trial_cost, damping * 0.1);
        } else {
            damping *= 10.0;
        }
    }
    let winding = of_point(point);
    let variance = cost / (samples.len() as f64 - 2.0);
    let covariance = inverse(normal(samples, point).0).map(|inverse| {
        let scale = [winding.resistance_ohm, winding.inductance_h];
        [0, 1].map(|i| [0, 1].map(|j| inverse[i][j] * variance * scale[i] * scale[j]))
    });
    match covariance {
        Some(covariance) if covariance[0][0].sqrt() < 0.1 * winding.resistance_ohm => {
            Ok((winding, covariance))
        }
        _ => refuse(
            STEP,
            format!(
                "the resistance cannot be identified: {:.3} ohm is uncertain by more than 10 %; \
                 expected a larger --current",
                winding.resistance_ohm
            ),
        ),
    }
}

fn of_point(point: [f64; 2]) -> Winding {
    Winding {
        resistance_ohm: point[0].exp(),
        inductance_h: point[1].exp(),
    }
}

fn residual(sample: &Sample, winding: &Winding) -> f64 {
    winding.current(sample.driven).sampled_a - sample.sampled_a
}

fn squares(samples: &[Sample], point: [f64; 2]) -> f64 {
    let winding = of_point(point);
    samples
        .iter()
        .map(|sample| residual(sample, &winding).powi(2))
        .sum()
}

/// The normal equations at a point.
fn normal(samples: &[Sample], point: [f64; 2]) -> ([[f64; 2]; 2], [f64; 2]) {
    const STEP: f64 = 1e-4;
    let (here, up) = (of_point(point), of_point([point[0] + STEP, point[1]]));
    let side = of_point([point[0], point[1] + STEP]);
    let (mut information, mut gradient) = ([[0.0; 2]; 2], [0.0; 2]);
    for sample in samples {
        let error = residual(sample, &here);
        let slope = [up, side].map(|winding| (residual(sample, &winding) - error) / STEP);
        for i in 0..2 {
            gradient[i] += slope[i] * error;
            for j in 0..2 {
                information[i][j] += slope[i] * slope[j];
            }
        }
    }
    (information, gradient)
}
