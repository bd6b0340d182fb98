//! Bounded Levenberg-Marquardt.
//!
//! The search variable `s` is the logarithm of a positive unknown, and the unknown itself
//! otherwise. Each step solves `(H + lambda D) ds = -g` over the unknowns that are not held by a
//! bound, `D` being the largest diagonal of `H` so far (Marquardt, SIAM J. Appl. Math. 11, 1963;
//! More, LNM 630, 1978), and is projected onto the bounds. `lambda` follows the ratio of actual to
//! predicted decrease (Nielsen, IMM-REP-1999-05). A step to a cost of NaN counts as one without a
//! decrease.

use nalgebra::{DMatrix, DVector};

use super::arrow;
use super::normal::{Normal, cost, normal};
use super::problem::Problem;
use super::unknowns::{Unknown, Unknowns};

/// Termination criteria.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// The most iterations.
    pub iterations: usize,
    /// The search has converged when a full Gauss-Newton step predicts a decrease below this share
    /// of the cost: at 1e-12 the distance to the optimum is 1e-6 sqrt(samples) standard errors.
    pub decrease: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            iterations: 200,
            decrease: 1e-12,
        }
    }
}

/// Why the search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Termination {
    /// The gradient vanished, or neither cost nor parameters moved any more.
    Converged,
    /// The most iterations were made.
    IterationLimit,
    /// No step lowered the cost although the gradient does not vanish.
    Stalled,
    /// The caller stopped it.
    Interrupted,
}

/// The end of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// The unknowns.
    pub point: Vec<f64>,
    /// Half the sum of squared residuals there.
    pub cost: f64,
    /// `J' J` there.
    pub information: DMatrix<f64>,
    /// Iterations made.
    pub iterations: usize,
    /// Why it ended.
    pub termination: Termination,
    /// The decrease of the cost that a full Gauss-Newton step predicted in the last iteration,
    /// deg^2; `None` where the matrix is singular.
    pub predicted: Option<f64>,
}

/// Largest change of the logarithm of an unknown in a step.
const LONGEST_STEP: f64 = 1.5;

/// The initial damping, which is cautious: the steepest direction seldom leads to the optimum.
const FIRST_LAMBDA: f64 = 1e-2;

/// The damping below which a step is a Gauss-Newton step.
const LEAST_LAMBDA: f64 = 1e-14;
const GREATEST_LAMBDA: f64 = 1e14;

/// Factor of `lambda` after the first trial step without a decrease.
const FIRST_GROWTH: f64 = 2.0;

struct Search<'a> {
    problem: &'a Problem,
    unknowns: &'a Unknowns,
    point: Vec<f64>,
    here: Normal,
    /// `J' J` by the unknowns themselves.
    information: DMatrix<f64>,
    scale: DVector<f64>,
    lambda: f64,
    /// Whether the last step succeeded at its first trial. The next one usually does, so that its
    /// derivatives are computed together with its cost.
    expects_success: bool,
    predicted: Option<f64>,
    /// The predicted decrease at which it has converged at any cost, deg^2.
    floor: f64,
}

/// Searches from `start`; `None` where the model diverges there.
pub fn search(
    problem: &Problem,
    unknowns: &Unknowns,
    start: &[f64],
    limits: &Limits,
    is_stopped: &(dyn Fn() -> bool + Sync),
) -> Option<Found> {
    search_down_to(0.0, (problem, unknowns), start, limits, is_stopped)
}

/// The same, which has also converged when a full Gauss-Newton step predicts a decrease below
/// `floor`, deg^2.
pub fn search_down_to(
    floor: f64,
    (problem, unknowns): (&Problem, &Unknowns),
    start: &[f64],
    limits: &Limits,
    is_stopped: &(dyn Fn() -> bool + Sync),
) -> Option<Found> {
    let here = normal(problem, unknowns, start);
    if !here.cost.is_finite() {
        return None;
    }
    let mut search = Search {
        scale: DVector::zeros(start.len()),
        problem,
        unknowns,
        point: start.to_vec(),
        here: here.clone(),
        information: here.hessian.clone(),
        lambda: FIRST_LAMBDA,
        expects_success: true,
        predicted: None,
        floor,
    };
    search.accept(here);
    let (mut iterations, mut termination) = (0, Termination::IterationLimit);
    while iterations < limits.iterations {
        if is_stopped() {
            termination = Termination::Interrupted;
            break;
        }
        iterations += 1;
        if let Some(end) = search.step(limits) {
            termination = end;
            break;
        }
    }
    Some(Found {
        point: search.point,
        cost: search.here.cost,
        information: search.information,
        iterations,
        termination,
        predicted: search.predicted,
    })
}

impl Search<'_> {
    /// Accepts cost and derivatives at the point, transformed to `s`.
    fn accept(&mut self, mut normal: Normal) {
        self.information.copy_from(&normal.hessian);
        for (i, unknown) in self.unknowns.list.iter().enumerate() {
            if unknown.is_log_scaled {
                let value = self.point[i];
                normal.gradient[i] *= value;
                normal.hessian.row_mut(i).scale_mut(value);
                normal.hessian.column_mut(i).scale_mut(value);
            }
        }
        for i in 0..self.point.len() {
            self.scale[i] = self.scale[i].max(normal.hessian[(i, i)]);
        }
        self.here = normal;
    }

    /// The unknowns that may move: not held by a bound, and with an influence on the angle.
    fn movable(&self) -> Vec<usize> {
        let is_movable = |i: &usize| {
            let (unknown, slope) = (&self.unknowns.list[*i], self.here.gradient[*i]);
            let is_held = (self.point[*i] <= unknown.low && slope >= 0.0)
                || (self.point[*i] >= unknown.high && slope <= 0.0);
            !is_held && self.here.hessian[(*i, *i)] > 0.0
        };
        (0..self.point.len()).filter(is_movable).collect()
    }

    /// One iteration; returns the reason if the search ends.
    fn step(&mut self, limits: &Limits) -> Option<Termination> {
        let movable = self.movable();
        self.predicted = self.solve(&movable, LEAST_LAMBDA).map(|s| s.1);
        let least = self.floor.max(limits.decrease * self.here.cost);
        if movable.is_empty() || self.predicted.is_some_and(|p| p <= least) {
            return Some(Termination::Converged);
        }
        let mut growth = FIRST_GROWTH;
        while self.lambda <= GREATEST_LAMBDA {
            let Some((step, predicted)) = self.solve(&movable, self.lambda) else {
                self.lambda *= 10.0;
                continue;
            };
            let trial = self.stepped(&movable, &step);
            if trial == self.point {
                return Some(Termination::Converged);
            }
            let (trial_cost, there) = self.evaluate(&trial);
            let decrease = self.here.cost - trial_cost;
            self.expects_success = decrease > 0.0 && growth == FIRST_GROWTH;
            if decrease > 0.0 {
                let there = there.unwrap_or_else(|| normal(self.problem, self.unknowns, &trial));
                self.point = trial;
                self.accept(there);
                let ratio = (decrease / predicted).min(1.0);
                let factor = (1.0 - (2.0 * ratio - 1.0).powi(3)).max(0.1);
                self.lambda = (self.lambda * factor).max(LEAST_LAMBDA);
                return None;
            }
            // No decrease where a negligible one was predicted: the limit of precision.
            if decrease.is_finite() && predicted <= 1e-9 * self.here.cost.max(f64::MIN_POSITIVE) {
                return Some(Termination::Converged);
            }
            self.lambda *= growth;
            growth *= 2.0;
        }
        Some(Termination::Stalled)
    }

    /// The cost of a trial point, and its derivatives where they are likely to be needed.
    fn evaluate(&self, trial: &[f64]) -> (f64, Option<Normal>) {
        if self.expects_success {
            let there = normal(self.problem, self.unknowns, trial);
            return (there.cost, Some(there));
        }
        (cost(self.problem, self.unknowns, trial), None)
    }

    /// The step of the movable unknowns and its predicted decrease.
    fn solve(&self, movable: &[usize], lambda: f64) -> Option<(DVector<f64>, f64)> {
        let n = movable.len();
        let entry = |i: usize, j: usize| {
            let (row, column) = (movable[i], movable[j]);
            let damping = if i == j {
                lambda * self.scale[row]
            } else {
                0.0
            };
            self.here.hessian[(row, column)] + damping
        };
        let gradient = DVector::from_fn(n, |i, _| self.here.gradient[movable[i]]);
        let step = -arrow::solve(self.unknowns, movable, entry, &gradient)?;
        let damped: f64 = (0..n)
            .map(|i| self.scale[movable[i]] * step[i].powi(2))
            .sum();
        // g ds + ds H ds/2 with (H + lambda D) ds = -g.
        let predicted = -0.5 * gradient.dot(&step) + 0.5 * lambda * damped;
        step.iter()
            .all(|s| s.is_finite())
            .then_some((step, predicted))
    }

    /// The point after a step, within bounds.
    fn stepped(&self, movable: &[usize], step: &DVector<f64>) -> Vec<f64> {
        let list = &self.unknowns.list;
        let longest = movable
            .iter()
            .zip(step)
            .filter(|(i, _)| list[**i].is_log_scaled);
        let longest = longest.fold(0.0_f64, |m, (_, s)| m.max(s.abs()));
        let share = (LONGEST_STEP / longest).min(1.0);
        let mut point = self.point.clone();
        for (&i, step) in movable.iter().zip(step) {
            let Unknown {
                low,
                high,
                is_log_scaled,
                ..
            } = list[i];
            let stepped = if is_log_scaled {
                point[i] * (step * share).exp()
            } else {
                point[i] + step * share
            };
            point[i] = stepped.max(low).min(high);
        }
        point
    }
}
