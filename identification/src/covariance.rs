//! Covariance of the estimates.
//!
//! For white residuals of variance `s^2` the covariance is the Cramer-Rao bound, `s^2 (J' J)^-1`.
//! The residuals of a model that is not exact are correlated in time, and the bound is then too
//! small; with their autocorrelation `R` the covariance is `(J' J)^-1 (sum J_i' R(i - j) J_j) (J'
//! J)^-1` (Morelli and Klein, J. Aircraft 34, 1997, "Accuracy of aerodynamic model parameters
//! estimated from flight test data").
//!
//! That formula assumes residuals of the same variance everywhere. Where they are larger where the
//! parameters act, the variances are those of the sandwich with `sum r^2 J J'` (White, Econometrica
//! 48, 1980), and for correlated residuals those of the sums over stretches of the recordings
//! (clustered errors: Liang and Zeger, Biometrika 73, 1986), where these are larger.

use nalgebra::DMatrix;

use super::blocks::Blocks;
use super::experiment::Experiment;
use super::experiment_fit::ExperimentFit;
use super::levenberg::Found;
use super::loss::Loss;
use super::normal::normal;
use super::observable::{Observable, weight};
use super::problem::Problem;
use super::unknowns::Unknowns;

/// Covariances of the unknowns at an optimum.
#[derive(Debug, Clone, PartialEq)]
pub struct Covariance {
    /// The unknowns in the rows of the matrices: those with influence that are not known to be at
    /// their bound.
    pub rows: Vec<usize>,
    /// Of each row, the references without which it is not known, and their exponents. Its variance
    /// is that with the references held.
    pub with: Vec<Vec<(usize, f64)>>,
    /// The unknowns that are known only in combination with others.
    pub traded: Vec<usize>,
    /// For white residuals.
    pub white: DMatrix<f64>,
    /// For residuals that are correlated in time.
    pub coloured: DMatrix<f64>,
    /// Standard deviation of the residuals, deg.
    pub noise_deg: f64,
    /// The sum of the squared influences of the residuals, deg^2.
    pub squares: f64,
}

impl Covariance {
    /// Multiplies the standard error of a row by `white` and `coloured`, with unchanged
    /// correlations.
    pub fn widen(&mut self, row: usize, white: f64, coloured: f64) {
        for (matrix, factor) in [(&mut self.white, white), (&mut self.coloured, coloured)] {
            matrix.row_mut(row).scale_mut(factor);
            matrix.column_mut(row).scale_mut(factor);
        }
    }

    /// Only the rows of unknowns that are known alone and not at a bound.
    pub fn alone(self, at_bound: &[bool]) -> Self {
        let kept: Vec<usize> = (0..self.rows.len())
            .filter(|row| self.with[*row].is_empty() && !at_bound[self.rows[*row]])
            .collect();
        let select = |matrix: &DMatrix<f64>| matrix.select_rows(&kept).select_columns(&kept);
        Self {
            rows: kept.iter().map(|row| self.rows[*row]).collect(),
            with: vec![Vec::new(); kept.len()],
            white: select(&self.white),
            coloured: select(&self.coloured),
            ..self
        }
    }
}

/// Ratio of variances from which the variance of the residuals is taken to change: beyond the
/// scatter of the estimate from some fifty samples in motion.
const HETEROSKEDASTIC: f64 = 1.5;

/// The covariances at the end of a search, with the fits of all experiments there, and the
/// stretches that they were computed from. `is_held` marks the unknowns that are known to
/// be at their bound.
pub fn covariance(
    problem: &Problem,
    unknowns: &Unknowns,
    found: &Found,
    is_held: &[bool],
    fits: &[ExperimentFit],
) -> (Covariance, Blocks) {
    let mut residuals: Vec<Vec<f64>> = fits.iter().map(compared).collect();
    let samples: usize = residuals.iter().map(Vec::len).sum();
    let mut hessian = found.information.clone();
    let loss = problem
        .experiments
        .first()
        .map_or(Loss::Squares, |run| run.loss);
    let mut slope = 1.0;
    if loss != Loss::Squares {
        // Of least squares, to which the influences of the residuals belong.
        let plain = problem.with_loss(Loss::Squares);
        hessian = normal(&plain, unknowns, &found.point).hessian;
        slope = loss.mean_slope(residuals.iter().flatten().copied());
        let all = residuals.iter_mut().flatten();
        all.for_each(|r| *r = loss.influence(*r, slope));
    }
    let hessian = &hessian;
    let acting = (0..found.point.len()).filter(|i| hessian[(*i, *i)] > 0.0);
    let values = unknowns.list.iter().zip(&found.point);
    let weights: Vec<f64> = values.map(|(unknown, at)| weight(unknown, *at)).collect();
    // An unknown at a bound for lack of information makes others unidentifiable, too.
    let mut observable = Observable::of(hessian, acting.collect(), &weights);
    let traded = observable.traded();
    observable.retain(|i| !is_held[i] || traded.contains(&i));
    let Observable { rows, with } = observable;
    let n = rows.len();
    let freedom = samples.saturating_sub(n).max(1) as f64;
    let squares: f64 = match loss {
        Loss::Squares => 2.0 * found.cost,
        Loss::Student { .. } => residuals.iter().flatten().map(|r| r * r).sum(),
    };
    let variance = squares / freedom;
    let scale: Vec<f64> = rows.iter().map(|i| hessian[(*i, *i)].sqrt()).collect();
    let normalised = DMatrix::from_fn(n, n, |i, j| {
        hessian[(rows[i], rows[j])] / (scale[i] * scale[j])
    });
    let inverse = normalised
        .cholesky()
        .map_or(DMatrix::zeros(n, n), |c| c.inverse());
    let inverse = DMatrix::from_fn(n, n, |i, j| inverse[(i, j)] / (scale[i] * scale[j]));
    let (all, is_coloured) = middle(problem, unknowns, &found.point, &residuals);
    let of_rows = |matrix: &DMatrix<f64>| {
        let matrix = matrix.select_rows(&rows).select_columns(&rows) * (samples as f64 / freedom);
        &inverse * matrix * &inverse
    };
    let influence = |residual: f64| loss.influence(residual, slope);
    let blocks = Blocks::of(problem, unknowns, &found.point, &influence);
    let mut covariance = Covariance {
        white: &inverse * variance,
        coloured: of_rows(&all),
        noise_deg: variance.sqrt(),
        squares,
        rows: rows.clone(),
        traded,
        with,
    };
    let uneven = of_rows(&blocks.heteroskedastic());
    let between = of_rows(&blocks.between_blocks());
    for row in 0..n {
        let white = covariance.white[(row, row)];
        let before = covariance.coloured[(row, row)];
        let mut greater = before;
        if uneven[(row, row)] > HETEROSKEDASTIC * white {
            greater = greater.max(uneven[(row, row)]);
        }
        if is_coloured {
            greater = greater.max(between[(row, row)]);
        }
        if before > 0.0 && greater > before {
            covariance.widen(row, 1.0, (greater / before).sqrt());
        }
    }
    (covariance, blocks)
}

/// The residuals that are not missing.
fn compared(fit: &ExperimentFit) -> Vec<f64> {
    let residuals = fit.residual_deg.iter().copied();
    residuals.filter(|r| !r.is_nan()).collect()
}

/// `sum J_i' R(i - j) J_j` of all unknowns, and whether the residuals of a run are correlated.
fn middle(
    problem: &Problem,
    unknowns: &Unknowns,
    point: &[f64],
    residuals: &[Vec<f64>],
) -> (DMatrix<f64>, bool) {
    let mut is_coloured = false;
    let mut all = DMatrix::zeros(point.len(), point.len());
    for (experiment, (run, own)) in problem.experiments.iter().zip(&unknowns.runs).enumerate() {
        let correlation = autocovariance(&residuals[experiment]);
        is_coloured |= correlation.len() > 1;
        let (values, angles) = (own.values(point), &run.recording.angle_deg);
        let width = own.free.len();
        let sum = if let [level] = correlation.as_slice() {
            let plain = &Experiment {
                loss: Loss::Squares,
                ..run.clone()
            };
            let sums = problem.model.sums(plain, &values, &own.free, angles);
            DMatrix::from_row_slice(width, width, &sums.information) * *level
        } else {
            let mut slopes = Vec::with_capacity(angles.len() * width);
            let output = &mut |i: usize, angle: f64, slope: &[f64]| {
                if !(angles[i] - angle).is_nan() {
                    slopes.extend_from_slice(slope);
                }
            };
            problem.model.sensitivity(run, &values, &own.free, output);
            weighted_products(&slopes, width, &correlation)
        };
        for (i, &row) in own.columns.iter().enumerate() {
            for (j, &column) in own.columns.iter().enumerate() {
                all[(row, column)] += sum[(i, j)];
            }
        }
    }
    (all, is_coloured)
}

/// The same of one run with derivatives `slopes`, sample after sample.
fn weighted_products(slopes: &[f64], width: usize, correlation: &[f64]) -> DMatrix<f64> {
    let mut sum = vec![0.0; width * width];
    let mut weighted = vec![0.0; width];
    let at = |i: usize| &slopes[i * width..(i + 1) * width];
    for i in 0..slopes.len() / width.max(1) {
        weighted.fill(0.0);
        for (lag, level) in correlation.iter().enumerate().take(i + 1) {
            let weight = if lag == 0 { *level } else { 2.0 * level };
            let terms = weighted.iter_mut().zip(at(i - lag));
            terms.for_each(|(place, slope)| *place += weight * slope);
        }
        for (row, by_row) in sum.chunks_exact_mut(width.max(1)).zip(at(i)) {
            let terms = row.iter_mut().zip(&weighted);
            terms.for_each(|(place, term)| *place += by_row * term);
        }
    }
    let sum = DMatrix::from_row_slice(width, width, &sum);
    // Each pair of different samples was taken once, in one order, with the weight of both.
    (&sum + sum.transpose()) * 0.5
}

/// Products of samples that are worth computing: a second.
const MOST_PRODUCTS: usize = 50_000_000;

/// Autocovariance of residuals from lag 0, to where it is lost in its own uncertainty.
fn autocovariance(residuals: &[f64]) -> Vec<f64> {
    let n = residuals.len();
    let at = |lag: usize| {
        let pairs = residuals[lag..].iter().zip(residuals);
        pairs.map(|(a, b)| a * b).sum::<f64>() / n as f64
    };
    let variance = at(0);
    let mut levels = vec![variance];
    // Twice the standard error of the autocorrelation of white noise, three times in a row.
    let band = 2.0 * variance / (n as f64).sqrt();
    let most = (n / 4).min(MOST_PRODUCTS / n.max(1)).max(1);
    let mut quiet = 0;
    for lag in 1..most {
        let level = at(lag);
        quiet = if level.abs() < band { quiet + 1 } else { 0 };
        levels.push(level);
        if quiet == 3 {
            levels.truncate(lag - 2);
            break;
        }
    }
    // Bartlett's taper keeps the sum from becoming negative.
    let count = levels.len() as f64;
    let tapered = levels.iter().enumerate();
    tapered
        .map(|(lag, level)| level * (1.0 - lag as f64 / count))
        .collect()
}
