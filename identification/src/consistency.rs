//! Whether all parts of the recordings want the same parameters.
//!
//! A standard error says how far an estimate moves with the noise. If a model lacks a property of
//! the actuator, its parameters also depend on the part of the recordings that they are fitted to,
//! and the standard error says nothing of that. Here each parameter in turn may have a value of its
//! own in a part of the recordings, all others being shared: one Gauss-Newton step from the optimum
//! yields both values and the error of their difference, without another search.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::arrow;
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
        let sums = Sums { unknowns, blocks };
        let test = Test::of(sums, covariance);
        let mut differences = Vec::new();
        for (row, &unknown) in covariance.rows.iter().enumerate() {
            let declared = unknowns.list[unknown];
            let parameter = &problem.model.parameters()[declared.parameter];
            let is_within = point[unknown] > declared.low && point[unknown] < declared.high;
            if !sums.is_shared(unknown) || !is_within || parameter.is_initial_state {
                continue;
            }
            let tested = test.parts.iter().filter_map(|(part, sum)| {
                let (there, elsewhere, z) = test.difference(row, unknown, sum)?;
                let values = [there, elsewhere].map(|(step, error)| {
                    let value = (point[unknown] + step).clamp(declared.low, declared.high);
                    (value, error)
                });
                Some(Difference {
                    unknown,
                    name: parameter.name,
                    unit: parameter.unit,
                    part: *part,
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

/// Gradient and information by the shared unknowns of a part of the recordings, at the best values
/// of the unknowns that belong to a recording.
type Sum = (DVector<f64>, DMatrix<f64>);

#[derive(Clone, Copy)]
struct Sums<'a> {
    unknowns: &'a Unknowns,
    blocks: &'a Blocks,
}

impl Sums<'_> {
    /// Whether all recordings share an unknown, or the drift, which follows the unknowns.
    fn is_shared(&self, row: usize) -> bool {
        let Some(unknown) = self.unknowns.list.get(row) else {
            return true;
        };
        unknown.experiment.is_none() || self.unknowns.runs.len() == 1
    }

    /// Of the selected stretches of one recording, or of the only one.
    fn of(&self, rows: &[usize], recording: usize, is_it: impl Fn(&Block) -> bool) -> Option<Sum> {
        let (shared, own): (Vec<usize>, Vec<usize>) = rows
            .iter()
            .filter(|row| {
                self.is_shared(**row) || self.unknowns.list[**row].experiment == Some(recording)
            })
            .partition(|row| self.is_shared(**row));
        let (count, owned) = (shared.len(), own.len());
        let selected = |block: &Block| block.experiment == recording && is_it(block);
        let (gradient, information) = self.blocks.sum(&[shared, own].concat(), selected);
        let of_shared = gradient.rows(0, count).into_owned();
        let matrix = information.view((0, 0), (count, count)).into_owned();
        let one = arrow::eliminate(
            information
                .view((count, count), (owned, owned))
                .into_owned(),
            &information.view((count, 0), (owned, count)).into_owned(),
            &gradient.rows(count, owned).into_owned(),
        )?;
        Some((of_shared - one.right, matrix - one.matrix))
    }

    /// Of each recording that determines its own unknowns.
    fn of_each(&self, rows: &[usize]) -> Vec<(usize, Sum)> {
        let recordings = 0..self.unknowns.runs.len();
        recordings
            .filter_map(|index| Some((index, self.of(rows, index, |_| true)?)))
            .collect()
    }
}

/// The sum over recordings; `None` of none.
fn total(sums: &[(usize, Sum)]) -> Option<Sum> {
    let sums = sums.iter().map(|(_, sum)| sum.clone());
    sums.reduce(|a, b| (a.0 + b.0, a.1 + b.1))
}

struct Test<'a> {
    covariance: &'a Covariance,
    /// The shared unknowns, in the order of the sums.
    shared: Vec<usize>,
    parts: Vec<(Part, Sum)>,
    all: Option<Sum>,
}

/// A step of a value, and the standard error of the value.
type Step = (f64, f64);

impl<'a> Test<'a> {
    fn of(sums: Sums<'_>, covariance: &'a Covariance) -> Self {
        let rows = &covariance.rows;
        let recordings = sums.of_each(rows);
        let all = total(&recordings);
        let parts = if sums.unknowns.runs.len() == 1 {
            let first = sums.of(rows, 0, |block| block.place < 0.5);
            Vec::from_iter(first.map(|sum| (Part::FirstHalf, sum)))
        } else {
            let part = |(index, sum)| (Part::Recording(index), sum);
            recordings.into_iter().map(part).collect()
        };
        let shared = rows.iter().copied().filter(|row| sums.is_shared(*row));
        Self {
            covariance,
            shared: shared.collect(),
            parts,
            all,
        }
    }

    /// The steps of an unknown in a part and elsewhere, and their difference in standard errors.
    fn difference(&self, row: usize, unknown: usize, there: &Sum) -> Option<(Step, Step, f64)> {
        let (of_all, of_there) = (self.all.as_ref()?, there);
        let own = self.shared.iter().position(|other| *other == unknown)?;
        // The unknown elsewhere takes its own row, the unknown there a row at the end.
        let n = self.shared.len();
        let entry = |a: usize, b: usize| match (a == n, b == n) {
            (true, true) => of_there.1[(own, own)],
            (true, false) | (false, true) if a.min(b) == own => 0.0,
            (true, false) | (false, true) => of_there.1[(own, a.min(b))],
            // Only samples elsewhere act on the unknown elsewhere.
            _ if a == own || b == own => of_all.1[(a, b)] - of_there.1[(a, b)],
            _ => of_all.1[(a, b)],
        };
        let matrix = DMatrix::from_fn(n + 1, n + 1, entry);
        let gradient = DVector::from_fn(n + 1, |a, _| match a {
            _ if a == n => of_there.0[own],
            _ if a == own => of_all.0[own] - of_there.0[own],
            _ => of_all.0[a],
        });
        let (step, inverse) = solved(&matrix, &gradient)?;
        let variance = self.variance(row);
        let error = |a: usize| (variance * inverse[(a, a)]).sqrt();
        let of_difference = inverse[(n, n)] + inverse[(own, own)] - 2.0 * inverse[(n, own)];
        let z = (step[n] - step[own]) / (variance * of_difference).sqrt();
        let steps = ((step[n], error(n)), (step[own], error(own)));
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
pub(super) fn drift_step(
    blocks: &Blocks,
    unknowns: &Unknowns,
    deviation_deg: f64,
) -> Option<Drift> {
    let width = unknowns.list.len();
    let all: Vec<usize> = (0..=width).collect();
    let information = blocks.sum(&all, |_| true).1;
    let acts = |row: &usize| information[(*row, *row)] > 0.0;
    if !acts(&width) {
        return None;
    }
    let rows: Vec<usize> = all.into_iter().filter(acts).collect();
    let sum = total(&Sums { unknowns, blocks }.of_each(&rows))?;
    let (step, inverse) = solved(&sum.1, &sum.0)?;
    let last = step.len() - 1;
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
