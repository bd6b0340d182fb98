//! Intervals beyond the standard errors of a search: of parameters that depend on the course of the
//! command between samples, of parameters that parts of the recordings disagree about, and of
//! parameters at a bound.

use nalgebra::{DMatrix, DVector};

use super::Solution;
use crate::blocks::Blocks;
use crate::consistency::Consistency;
use crate::covariance::Covariance;
use crate::fit::Estimate;
use crate::levenberg::Found;
use crate::problem::{Problem, Spec};
use crate::statistics::distributions::{COVERED, two_sided};
use crate::unknowns::{Unknown, Unknowns};

/// Correlation near one, from which an estimate is taken to be determined only with a small error.
const INSEPARABLE: f64 = 0.995;
/// Residuals in those of the noise up to which a model describes its recordings.
const DESCRIBED: f64 = 1.1;
/// Independent values of the error of a model in a recording: its motions.
const EVENTS: f64 = 16.0;
/// Factor on the errors of the model within an input, for those between inputs: with it and the
/// ratio nine of ten estimates of black boxes from different inputs of one actuator agree within
/// two standard errors.
const BETWEEN_INPUTS: f64 = 4.0;
/// That relative error.
const SMALL: f64 = 0.1;

/// Widens the errors of all parameters where the hold of the command is not determined, and of each
/// parameter about which the parts of the recordings disagree.
pub fn widen(
    problem: &Problem,
    solution: &Solution,
    consistency: &Consistency,
    covariance: &mut Covariance,
) {
    let rows = covariance.rows.clone();
    let row_of = |unknown: usize| rows.iter().position(|row| *row == unknown);
    for difference in &consistency.differences {
        let Some(row) = row_of(difference.unknown) else {
            continue;
        };
        // The mean of two values that scatter like these has half their distance as its error.
        let least = 0.5 * (difference.there.0 - difference.elsewhere.0).abs();
        let error = covariance.coloured[(row, row)].sqrt();
        if error > 0.0 && least > error {
            covariance.widen(row, 1.0, least / error);
        }
    }
    let delay = |unknown: &Unknown| {
        unknown.experiment.is_none()
            && problem.model.parameter_index("delay_s") == Some(unknown.parameter)
    };
    let delay = solution.unknowns.list.iter().position(delay);
    if let (Some((below, above)), Some(row)) = (solution.delay_open_s, delay.and_then(row_of)) {
        // Any value in that interval is as likely as another.
        let open = (below * below - below * above + above * above) / 3.0;
        let factor = |matrix: &DMatrix<f64>| (1.0 + open / matrix[(row, row)]).sqrt();
        let factors = (factor(&covariance.white), factor(&covariance.coloured));
        if factors.0.is_finite() && factors.1.is_finite() {
            covariance.widen(row, factors.0, factors.1);
        }
    }
    // The interval around the estimate for a smooth command covers that for a held one, too. The
    // delay differs by half a sample; what a hold does beyond that, the other parameters take up.
    let one_sided = two_sided(2.0 * COVERED - 1.0);
    for (unknown, difference) in solution.hold_differences.iter().enumerate() {
        let Some(row) = row_of(unknown) else {
            continue;
        };
        let factor = |matrix: &DMatrix<f64>| {
            let error = matrix[(row, row)].sqrt();
            let widened = (difference.abs() + one_sided * error) / two_sided(COVERED);
            (widened / error).max(1.0)
        };
        let factors = (factor(&covariance.white), factor(&covariance.coloured));
        if factors.0.is_finite() && factors.1.is_finite() {
            covariance.widen(row, factors.0, factors.1);
        }
    }
}

/// Widens the errors for coloured residuals by those of a model that does not describe its
/// recordings. Its estimates depend on the input: the part of the residuals that is not noise is
/// the same wherever the input repeats, so that it counts as a few independent values only, and
/// another input has another one.
pub fn include_misfit(ratio: f64, samples: usize, covariance: &mut Covariance) {
    if ratio.is_nan() || ratio < DESCRIBED {
        return;
    }
    let share = 1.0 - (DESCRIBED / ratio).powi(2);
    let events = BETWEEN_INPUTS * (share * samples as f64 / EVENTS).sqrt();
    for row in 0..covariance.rows.len() {
        let white = covariance.white[(row, row)].sqrt();
        let coloured = covariance.coloured[(row, row)].sqrt();
        let factor = ratio.max(events * white / coloured);
        if factor.is_finite() {
            covariance.widen(row, 1.0, factor);
        }
    }
}

/// For each unknown at a bound, how far from it the other end of its 95 % interval is: where the
/// cost, minimised over the others to second order, exceeds the optimum as an insignificant
/// parameter makes it once in twenty cases (Venzon and Moolgavkar, Applied Statistics 37, 1988);
/// and by how many standard errors it would be beyond the bound.
pub fn profiles(
    unknowns: &Unknowns,
    found: &Found,
    at_bound: &[bool],
    blocks: &Blocks,
    covariance: &Covariance,
) -> Vec<(f64, f64)> {
    let mut ends = vec![(f64::NAN, 0.0); found.point.len()];
    if !at_bound.contains(&true) {
        return ends;
    }
    let all: Vec<usize> = (0..found.point.len()).collect();
    let (gradient, information) = blocks.sum(&all, |_| true);
    let rows: Vec<usize> = covariance
        .rows
        .iter()
        .copied()
        .filter(|row| !at_bound[*row])
        .collect();
    let larger = |row: usize| covariance.coloured[(row, row)] / covariance.white[(row, row)];
    let larger = (0..covariance.rows.len())
        .map(larger)
        .filter(|ratio| ratio.is_finite());
    let larger = larger.fold(1.0, f64::max).sqrt();
    let others = information
        .select_rows(&rows)
        .select_columns(&rows)
        .cholesky();
    for (unknown, _) in at_bound.iter().enumerate().filter(|(_, held)| **held) {
        let own = information[(unknown, unknown)];
        let cross = DVector::from_fn(rows.len(), |i, _| information[(rows[i], unknown)]);
        let by_others = others.as_ref().map_or(0.0, |o| cross.dot(&o.solve(&cross)));
        let curvature = (own - by_others).max(0.0);
        let inward = if found.point[unknown] <= unknowns.list[unknown].low {
            1.0
        } else {
            -1.0
        };
        // Negative where the cost decreases inward, as of a neglected effect.
        let slope = -inward * gradient[unknown];
        let allowed = 0.5 * (two_sided(COVERED) * covariance.noise_deg).powi(2);
        let root = (slope * slope + 2.0 * curvature * allowed).sqrt();
        let away = 2.0 * allowed / (slope + root);
        let declared = &unknowns.list[unknown];
        let at = found.point[unknown];
        if away.is_finite() {
            let end = (at + inward * away).clamp(declared.low, declared.high);
            ends[unknown] = (
                end,
                slope.max(0.0) / (larger * covariance.noise_deg * curvature.sqrt()),
            );
        }
    }
    ends
}

/// Marks estimates as not identifiable that are nearly inseparable from another and have a
/// considerable error.
pub fn leave_open_correlated(
    problem: &Problem,
    rows: &[usize],
    correlation: &DMatrix<f64>,
    estimates: &mut [Estimate],
) {
    for (i, &index) in rows.iter().enumerate() {
        let name = estimates[index].name;
        let spec = problem.specs.iter().find(|s| s.parameter.name == name);
        let largest = (0..rows.len()).filter(|j| *j != i);
        let largest = largest.fold(0.0_f64, |m, j| m.max(correlation[(i, j)].abs()));
        let estimate = &mut estimates[index];
        let error = estimate
            .standard_error
            .max(estimate.standard_error_coloured);
        let is_small = error <= SMALL * estimate.value.abs() || !spec.is_some_and(Spec::has_scale);
        estimate.identifiable &= largest < INSEPARABLE || is_small;
    }
}
