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
use crate::unknowns::Unknowns;

/// Correlation near one, from which an estimate is taken to be determined only with a small error.
const INSEPARABLE: f64 = 0.995;
/// That relative error.
const SMALL: f64 = 0.1;

/// Widens the errors of all parameters where the hold of the command is not determined, and of each
/// parameter about which the parts of the recordings disagree.
pub fn widen(solution: &Solution, consistency: &Consistency, covariance: &mut Covariance) {
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

/// For each unknown at a bound, how far from it the other end of its 95 % interval is: where the
/// cost, minimised over the others to second order, exceeds the optimum as an insignificant
/// parameter makes it once in twenty cases (Venzon and Moolgavkar, Applied Statistics 37, 1988).
pub fn profiles(
    unknowns: &Unknowns,
    found: &Found,
    is_held: &[bool],
    blocks: &Blocks,
    covariance: &Covariance,
) -> Vec<f64> {
    let mut ends = vec![f64::NAN; found.point.len()];
    if !is_held.contains(&true) {
        return ends;
    }
    let (gradient, information) = blocks.sum(|_| true);
    let rows = &covariance.rows;
    let others = information
        .select_rows(rows)
        .select_columns(rows)
        .cholesky();
    for (unknown, _) in is_held.iter().enumerate().filter(|(_, held)| **held) {
        let own = information[(unknown, unknown)];
        let cross = DVector::from_fn(rows.len(), |i, _| information[(rows[i], unknown)]);
        let by_others = others.as_ref().map_or(0.0, |o| cross.dot(&o.solve(&cross)));
        let curvature = (own - by_others).max(0.0);
        let slope = gradient[unknown].abs();
        let allowed = 0.5 * (two_sided(COVERED) * covariance.noise_deg).powi(2);
        let root = (slope * slope + 2.0 * curvature * allowed).sqrt();
        let away = 2.0 * allowed / (slope + root);
        let declared = &unknowns.list[unknown];
        let at = found.point[unknown];
        let inward = if at <= declared.low { 1.0 } else { -1.0 };
        if away.is_finite() {
            ends[unknown] = (at + inward * away).clamp(declared.low, declared.high);
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
