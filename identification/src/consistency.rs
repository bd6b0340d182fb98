//! Whether all parts of the recordings want the same parameters.
//!
//! A standard error says how far an estimate moves with the noise. If a model lacks a property of
//! the actuator, its parameters also depend on the part of the recordings that they are fitted to,
//! and the standard error says nothing of that. Here each parameter in turn may have a value of its
//! own in a part of the recordings, all others being shared: one Gauss-Newton step from the optimum
//! yields both values and the error of their difference, without another search.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::blocks::{Block, Blocks};
use super::covariance::Covariance;
use super::problem::Problem;
use super::unknowns::Unknowns;

/// Errors of a difference from which it is reported: exceeded by chance once in 16,000.
const SIGNIFICANT: f64 = 4.0;

/// The part of the recordings with a separate value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// The first half of the only recording.
    FirstHalf,
    /// A recording of several.
    Recording(usize),
}

/// Two values of a parameter that differ by more than chance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// The index of the unknown.
    pub(super) unknown: usize,
    /// The parameter.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// The part of the recordings.
    pub part: Part,
    /// Its value in that part, with its standard error.
    pub there: (f64, f64),
    /// Its value elsewhere, with its standard error.
    pub elsewhere: (f64, f64),
    /// The difference in standard errors of the difference.
    pub z: f64,
}

/// The clock of the angle against that of the command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drift {
    /// By how much the clock of the angle is slow: a sample labelled `t` is of the instant
    /// `(1 + share) t` of the command's clock.
    pub share: f64,
    /// Its standard error.
    pub standard_error: f64,
}

/// What disagrees.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Consistency {
    /// Parameters with different values in parts of the recordings.
    pub differences: Vec<Difference>,
    /// A delay that grows or shrinks with the time.
    pub drift: Option<Drift>,
}

impl Consistency {
    /// Tests all identifiable parameters at an optimum.
    pub fn of(
        problem: &Problem,
        unknowns: &Unknowns,
        point: &[f64],
        blocks: &Blocks,
        covariance: &Covariance,
    ) -> Self {
        let test = Test { blocks, covariance };
        let mut differences = Vec::new();
        let count = problem.experiments.len();
        let parts = match count {
            1 => vec![Part::FirstHalf],
            _ => (0..count).map(Part::Recording).collect(),
        };
        for (row, &unknown) in covariance.rows.iter().enumerate() {
            let declared = unknowns.list[unknown];
            let is_shared = declared.experiment.is_none() || count == 1;
            let parameter = &problem.model.parameters()[declared.parameter];
            let is_within = point[unknown] > declared.low && point[unknown] < declared.high;
            if !is_shared || !is_within || parameter.is_initial_state {
                continue;
            }
            let tested = parts.iter().filter_map(|&part| {
                let (there, elsewhere, z) = test.difference(row, unknown, part)?;
                let values = [there, elsewhere].map(|(step, error)| {
                    let value = (point[unknown] + step).clamp(declared.low, declared.high);
                    (value, error)
                });
                Some(Difference {
                    unknown,
                    name: parameter.name,
                    unit: parameter.unit,
                    part,
                    there: values[0],
                    elsewhere: values[1],
                    z,
                })
            });
            let largest = tested.max_by(|a, b| a.z.abs().total_cmp(&b.z.abs()));
            differences.extend(largest.filter(|d| d.z.abs() > SIGNIFICANT));
        }
        Self {
            differences,
            drift: None,
        }
    }
}

struct Test<'a> {
    blocks: &'a Blocks,
    covariance: &'a Covariance,
}

/// A step of a value, and the standard error of the value.
type Step = (f64, f64);

impl Test<'_> {
    /// The steps of an unknown in a part and elsewhere, and their difference in standard errors.
    fn difference(&self, row: usize, unknown: usize, part: Part) -> Option<(Step, Step, f64)> {
        let is_there = |block: &Block| match part {
            Part::FirstHalf => block.place < 0.5,
            Part::Recording(index) => block.experiment == index,
        };
        let (there, of_there) = self.blocks.sum(is_there);
        let (all, of_all) = self.blocks.sum(|_| true);
        let rows = &self.covariance.rows;
        // The unknown elsewhere takes its own row, the unknown there a row at the end.
        let n = rows.len();
        let entry = |a: usize, b: usize| match (a == n, b == n) {
            (true, true) => of_there[(unknown, unknown)],
            (true, false) | (false, true) => {
                let other = rows[a.min(b)];
                if other == unknown {
                    0.0
                } else {
                    of_there[(unknown, other)]
                }
            }
            (false, false) => {
                let (i, j) = (rows[a], rows[b]);
                // Only samples elsewhere act on the unknown elsewhere.
                if i == unknown || j == unknown {
                    of_all[(i, j)] - of_there[(i, j)]
                } else {
                    of_all[(i, j)]
                }
            }
        };
        let matrix = DMatrix::from_fn(n + 1, n + 1, entry);
        let gradient = DVector::from_fn(n + 1, |a, _| {
            if a == n {
                there[unknown]
            } else if rows[a] == unknown {
                all[unknown] - there[unknown]
            } else {
                all[rows[a]]
            }
        });
        let (step, inverse) = solved(&matrix, &gradient)?;
        let variance = self.variance(row);
        let error = |a: usize| (variance * inverse[(a, a)]).sqrt();
        let of_difference = inverse[(n, n)] + inverse[(row, row)] - 2.0 * inverse[(n, row)];
        let z = (step[n] - step[row]) / (variance * of_difference).sqrt();
        let steps = ((step[n], error(n)), (step[row], error(row)));
        z.is_finite().then_some((steps.0, steps.1, z))
    }

    /// The variance of a residual, with the factor by which that of an estimate is larger.
    fn variance(&self, row: usize) -> f64 {
        let Covariance {
            white, coloured, ..
        } = self.covariance;
        let factor = (coloured[(row, row)] / white[(row, row)]).max(1.0);
        self.covariance.noise_deg.powi(2) * factor
    }
}

/// The step of the drift from zero beside those of all unknowns, for residuals of this standard
/// deviation; `None` where it cannot be distinguished from them.
pub(super) fn drift_step(blocks: &Blocks, width: usize, deviation_deg: f64) -> Option<Drift> {
    let (gradient, information) = blocks.sum(|_| true);
    let acts = |row: &usize| information[(*row, *row)] > 0.0;
    if !acts(&width) {
        return None;
    }
    let rows: Vec<usize> = (0..=width).filter(acts).collect();
    let matrix = information.select_rows(&rows).select_columns(&rows);
    let (step, inverse) = solved(&matrix, &gradient.select_rows(&rows))?;
    let last = rows.len() - 1;
    // A delay that grows with the time is an angle whose clock is fast: sampled later than
    // labelled, it is ahead.
    Some(Drift {
        share: -step[last],
        standard_error: deviation_deg * inverse[(last, last)].sqrt(),
    })
}

/// The solution of normal equations, and the inverse of their matrix; `None` where it is singular.
fn solved(matrix: &DMatrix<f64>, gradient: &DVector<f64>) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let n = matrix.nrows();
    let scale = DVector::from_fn(n, |i, _| matrix[(i, i)].sqrt());
    if scale.iter().any(|s| s.is_nan() || *s <= 0.0) {
        return None;
    }
    let normalised = DMatrix::from_fn(n, n, |i, j| matrix[(i, j)] / (scale[i] * scale[j]));
    // The least share of an unknown that the others do not have, as in the covariance.
    let cholesky = Cholesky::new(normalised)?;
    if cholesky.l_dirty().diagonal().min() < 1e-4 {
        return None;
    }
    let inverse = cholesky.inverse();
    let inverse = DMatrix::from_fn(n, n, |i, j| inverse[(i, j)] / (scale[i] * scale[j]));
    Some((&inverse * gradient, inverse))
}
