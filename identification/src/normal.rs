//! Cost, gradient and Gauss-Newton matrix of a problem: its normal equations.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::problem::Problem;
use super::unknowns::Unknowns;

/// The least-squares problem around a point: `cost + g dx + dx H dx/2`.
#[derive(Debug, Clone, PartialEq)]
pub struct Normal {
    /// Half the sum of squared residuals, deg^2; not finite where the model diverges.
    pub cost: f64,
    /// Derivative of the cost by the unknowns.
    pub gradient: DVector<f64>,
    /// `J' J`, `J` being the derivatives of the angle.
    pub hessian: DMatrix<f64>,
    /// Residuals that were compared.
    pub samples: usize,
}

/// Samples that are evaluated in one thread at least.
const WORTH_A_THREAD: usize = 4000;

/// Half the sum of squared residuals, deg^2.
pub fn cost(problem: &Problem, unknowns: &Unknowns, point: &[f64]) -> f64 {
    over_experiments(problem, |experiment| {
        let run = &problem.experiments[experiment];
        let values = unknowns.runs[experiment].values(point);
        let angles = &run.recording.angle_deg;
        0.5 * problem.model.sums(run, &values, &[], angles).squares
    })
    .into_iter()
    .sum()
}

/// Cost, gradient and Gauss-Newton matrix.
pub fn normal(problem: &Problem, unknowns: &Unknowns, point: &[f64]) -> Normal {
    let width = unknowns.list.len();
    let mut all = Normal {
        cost: 0.0,
        gradient: DVector::zeros(width),
        hessian: DMatrix::zeros(width, width),
        samples: 0,
    };
    let parts = over_experiments(problem, |experiment| {
        part(problem, unknowns, point, experiment)
    });
    for (run, part) in unknowns.runs.iter().zip(parts) {
        all.cost += part.cost;
        all.samples += part.samples;
        for (i, &row) in run.columns.iter().enumerate() {
            all.gradient[row] += part.gradient[i];
            for (j, &column) in run.columns.iter().enumerate() {
                all.hessian[(row, column)] += part.hessian[(i, j)];
            }
        }
    }
    all
}

/// The contribution of one experiment, by its own free parameters.
fn part(problem: &Problem, unknowns: &Unknowns, point: &[f64], experiment: usize) -> Normal {
    let run = &problem.experiments[experiment];
    let own = &unknowns.runs[experiment];
    let (width, angles) = (own.free.len(), &run.recording.angle_deg);
    let sums = problem
        .model
        .sums(run, &own.values(point), &own.free, angles);
    Normal {
        cost: 0.5 * sums.squares,
        gradient: -DVector::from_vec(sums.products),
        hessian: DMatrix::from_row_slice(width, width, &sums.information),
        samples: sums.samples,
    }
}

/// Applies a function to each experiment, in as many threads as there are samples for.
fn over_experiments<T: Send>(problem: &Problem, f: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    let count = problem.experiments.len();
    let samples: usize = problem.experiments.iter().map(|e| e.len()).sum();
    let of_thread = (WORTH_A_THREAD * count).div_ceil(samples.max(1));
    if of_thread < count {
        let all = (0..count).into_par_iter().with_min_len(of_thread);
        all.map(f).collect()
    } else {
        (0..count).map(f).collect()
    }
}
