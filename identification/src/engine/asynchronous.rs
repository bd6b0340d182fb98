//! Steps of the command between the samples of a recording.
//!
//! A log that samples a command which does not change at its instants shows each step up to one
//! interval late, a different time for each step. If the responses to the steps are shifted
//! against each other within that interval, each step has an instant of its own. The delay is then
//! determined only up to the interval that all steps leave open.

use model_core::sensors::noise::Noise;
use nalgebra::{DMatrix, DVector};

use super::{Options, Progress, Solution, drift, outcome};
use crate::experiment::Experiment;
use crate::levenberg::{Found, Limits, search};
use crate::misfit::Misfit;
use crate::problem::Problem;

/// The most steps with instants of their own.
const MOST_STEPS: usize = 200;
/// Gauss-Newton steps, each followed by a search.
const ROUNDS: usize = 4;
/// Share of the cost that the instants explain at least.
const EXPLAINED: f64 = 0.2;
/// Relative decrease of the cost at which the instants have converged.
const CONVERGED: f64 = 1e-3;
/// Residuals in those of the noise from which the instants of the steps are searched for.
const UNEXPLAINED: f64 = 1.2;
/// Random instants from which the search begins, and its termination criteria there.
const DRAWS: u64 = 8;
const ROUGH: Limits = Limits {
    iterations: 30,
    decrease: 1e-4,
};
/// Error of the instant of a step, in intervals, from which it is not known.
const VAGUE: f64 = 0.25;
/// The earliest instant of a step, in intervals: after that of a step one sample before.
const EARLIEST: f64 = 0.98;

/// Intervals of the shortest from which one is a gap.
const GAP: f64 = 3.0;
/// Share of the information about an unknown that is rounding.
const SINGULAR: f64 = 1e-9;

/// A step of the command.
#[derive(Clone)]
struct Step {
    run: usize,
    segment: usize,
    /// Time from the sample before, s.
    interval_s: f64,
    /// Its instant after that of the log, s.
    shift_s: f64,
}

/// Gives each step its own instant where the responses differ, and notes the delay's open interval.
pub fn decided(
    problem: &Problem,
    mut usual: Solution,
    options: &Options,
    progress: &dyn Progress,
) -> (Option<Problem>, Solution) {
    // A log with the duty is of the controller itself, which samples the command at its instants.
    let is_of_controller = |experiment: &Experiment| !experiment.drive.is_empty();
    if problem.experiments.iter().any(is_of_controller) {
        return (None, usual);
    }
    let (Some(delay), Some(steps)) = (delay_column(problem, &usual), steps(problem)) else {
        return (None, usual);
    };
    let interval_s = steps
        .iter()
        .map(|step| step.interval_s)
        .fold(f64::MAX, f64::min);
    let Some(first) = instants(problem, &usual, delay, &steps) else {
        return (None, usual);
    };
    let deviation_deg = (2.0 * usual.found.cost / first.samples).sqrt();
    let is_vague = steps.len() == 1 || first.error(deviation_deg) > VAGUE * interval_s;
    let fits = outcome::fits(problem, &usual.unknowns, &usual.found.point);
    let misfit = Misfit::of(&problem.experiments, &fits).ratio;
    if !is_vague && misfit < UNEXPLAINED {
        return (None, usual);
    }
    let shifting = Shifting {
        problem,
        usual: &usual,
        delay,
        options,
        progress,
    };
    let solved = if is_vague {
        None
    } else {
        shifting.solved(steps)
    };
    // A clock that drifts shifts later steps more.
    let drifts = || drift::of(problem, &usual.unknowns, &usual.found, &fits).is_some();
    if let Some((shifted, solution)) = solved.filter(|_| !drifts()) {
        return (Some(shifted), solution);
    }
    // A single step, or vague ones, may be late or not.
    usual.delay_open_s = Some((0.0, interval_s));
    (None, usual)
}

/// The search for the instants.
struct Shifting<'a> {
    problem: &'a Problem,
    usual: &'a Solution,
    delay: usize,
    options: &'a Options,
    progress: &'a dyn Progress,
}

impl Shifting<'_> {
    /// The problem with instants that explain much of the cost, and its optimum.
    fn solved(&self, mut steps: Vec<Step>) -> Option<(Problem, Solution)> {
        let mut solution = self.drawn(&mut steps)?;
        for _ in 0..ROUNDS {
            let shifted = with_shifts(self.problem, &steps);
            let next = instants(&shifted, &solution, self.delay, &steps)?;
            let mut moved = steps.clone();
            for (step, shift_s) in moved.iter_mut().zip(&next.shifts_s) {
                step.shift_s += shift_s.clamp(-step.interval_s, step.interval_s);
            }
            let latest = moved
                .iter()
                .map(|step| step.shift_s)
                .fold(f64::MIN, f64::max);
            for step in &mut moved {
                step.shift_s = (step.shift_s - latest).max(-EARLIEST * step.interval_s);
            }
            let mut start = solution.found.point.clone();
            start[self.delay] += latest;
            let next = self.search(&moved, &start, &self.options.limits)?;
            if next.cost >= solution.found.cost {
                break;
            }
            let has_converged = next.cost > (1.0 - CONVERGED) * solution.found.cost;
            (steps, solution.found) = (moved, next);
            if has_converged {
                break;
            }
        }
        if solution.found.cost > (1.0 - EXPLAINED) * self.usual.found.cost {
            return None;
        }
        // A common shift is one of the delay: what all steps allow, and its middle.
        let to_earliest = steps.iter().map(|step| -step.interval_s - step.shift_s);
        let to_earliest = to_earliest.fold(f64::MIN, f64::max);
        let to_latest = steps.iter().map(|step| -step.shift_s);
        let to_latest = to_latest.fold(f64::MAX, f64::min);
        let open = (to_latest - to_earliest).max(0.0);
        let to_middle = 0.5 * (to_latest + to_earliest);
        steps.iter_mut().for_each(|step| step.shift_s += to_middle);
        solution.found.point[self.delay] -= to_middle;
        solution.delay_open_s = Some((0.5 * open, 0.5 * open));
        Some((with_shifts(self.problem, &steps), solution))
    }

    /// The best of some random instants: the instants of the optimum without them are hidden by
    /// limits and poles that have taken up the difference.
    fn drawn(&self, steps: &mut Vec<Step>) -> Option<Solution> {
        let unknowns = &self.usual.unknowns;
        let mut noise = Noise::new(self.options.seed, DRAWS);
        let mut best: Option<(Vec<Step>, Found)> = None;
        for _ in 0..DRAWS {
            let mut drawn = steps.clone();
            for step in &mut drawn {
                step.shift_s = -EARLIEST * step.interval_s * noise.gaussian(1e3).rem_euclid(1.0);
            }
            for start in [&self.usual.found.point, &unknowns.start()] {
                let found = self.search(&drawn, start, &ROUGH)?;
                if best
                    .as_ref()
                    .is_none_or(|(_, least)| found.cost < least.cost)
                {
                    best = Some((drawn.clone(), found));
                }
            }
        }
        let (drawn, found) = best?;
        *steps = drawn;
        Some(Solution {
            found,
            ..self.usual.clone()
        })
    }

    fn search(&self, steps: &[Step], start: &[f64], limits: &Limits) -> Option<Found> {
        let declared = &self.usual.unknowns.list[self.delay];
        let mut start = start.to_vec();
        start[self.delay] = start[self.delay].clamp(declared.low, declared.high);
        let shifted = with_shifts(self.problem, steps);
        let is_stopped = || self.progress.is_stopped();
        search(&shifted, &self.usual.unknowns, &start, limits, &is_stopped)
    }
}

/// The unknown that is the delay of all runs.
fn delay_column(problem: &Problem, solution: &Solution) -> Option<usize> {
    let delay = problem.model.parameter_index("delay_s")?;
    let mut unknowns = solution.unknowns.list.iter();
    unknowns.position(|unknown| unknown.parameter == delay && unknown.experiment.is_none())
}

/// The steps between constant levels; `None` where there is none, or too many.
fn steps(problem: &Problem) -> Option<Vec<Step>> {
    let mut steps = Vec::new();
    for (run, experiment) in problem.experiments.iter().enumerate() {
        let command = &experiment.command;
        for segment in 1..command.len() {
            if !(command[segment].is_constant && command[segment - 1].is_constant) {
                return None;
            }
            let start_ns = command[segment].start_ns;
            let next = experiment.time_ns.partition_point(|t| *t < start_ns);
            let before_ns = *experiment.time_ns.get(next.checked_sub(1)?)?;
            steps.push(Step {
                run,
                segment,
                interval_s: (start_ns - before_ns) as f64 * 1e-9,
                shift_s: 0.0,
            });
        }
    }
    // The samples after a gap say nothing about those in it.
    let least_s = steps.iter().map(|step: &Step| step.interval_s);
    let least_s = least_s.fold(f64::MAX, f64::min);
    steps.retain(|step| step.interval_s < GAP * least_s);
    (1..=MOST_STEPS).contains(&steps.len()).then_some(steps)
}

/// The problem with the steps at their instants.
fn with_shifts(problem: &Problem, steps: &[Step]) -> Problem {
    let mut runs: Vec<Experiment> = problem.experiments.clone();
    for step in steps {
        let shift_ns = (step.shift_s * 1e9).round() as i64;
        runs[step.run].command[step.segment].start_ns += shift_ns;
    }
    problem.with_experiments(runs)
}

/// A Gauss-Newton step of the instants of all steps beside the other unknowns.
struct Instants {
    shifts_s: Vec<f64>,
    /// Information about each instant.
    information: Vec<f64>,
    samples: f64,
}

impl Instants {
    /// The median error of an instant, s.
    fn error(&self, deviation_deg: f64) -> f64 {
        let mut information = self.information.clone();
        information.sort_unstable_by(f64::total_cmp);
        deviation_deg / information[information.len() / 2].sqrt()
    }
}

fn instants(
    problem: &Problem,
    solution: &Solution,
    delay: usize,
    steps: &[Step],
) -> Option<Instants> {
    let (n, count) = (solution.found.point.len(), steps.len());
    let delay_ns = (solution.found.point[delay] * 1e9) as i64;
    let mut common = (DMatrix::zeros(n, n), DVector::zeros(n));
    let mut cross = DMatrix::zeros(n, count);
    let mut own = vec![(0.0, 0.0); count];
    let mut samples = 0.0;
    for (run, experiment) in problem.experiments.iter().enumerate() {
        let unknowns = &solution.unknowns.runs[run];
        let late = unknowns
            .columns
            .iter()
            .position(|column| *column == delay)?;
        let mut following = steps
            .iter()
            .position(|step| step.run == run)
            .unwrap_or(count);
        let mut current = None;
        let angles = &experiment.recording.angle_deg;
        let output = &mut |i: usize, angle: f64, slopes: &[f64]| {
            let residual = angles[i] - angle;
            if residual.is_nan() {
                return;
            }
            let start_ns = |step: &Step| experiment.command[step.segment].start_ns + delay_ns;
            while let Some(step) = steps.get(following).filter(|step| step.run == run)
                && start_ns(step) <= experiment.time_ns[i]
            {
                current = Some(following);
                following += 1;
            }
            samples += 1.0;
            let is_common = |k: &usize| *k != late;
            for a in (0..slopes.len()).filter(is_common) {
                let row = unknowns.columns[a];
                common.1[row] += residual * slopes[a];
                for b in (0..slopes.len()).filter(is_common) {
                    common.0[(row, unknowns.columns[b])] += slopes[a] * slopes[b];
                }
                if let Some(step) = current {
                    cross[(row, step)] += slopes[a] * slopes[late];
                }
            }
            if let Some(step) = current {
                own[step].0 += slopes[late] * slopes[late];
                own[step].1 += residual * slopes[late];
            }
        };
        let values = unknowns.values(&solution.found.point);
        problem
            .model
            .sensitivity(experiment, &values, &unknowns.free, output);
    }
    let variance = 2.0 * solution.found.cost / samples;
    solved(common, &cross, &own, steps, variance, samples)
}

/// The solution of the normal equations, in which no sample is of two steps.
fn solved(
    (mut information, gradient): (DMatrix<f64>, DVector<f64>),
    cross: &DMatrix<f64>,
    own: &[(f64, f64)],
    steps: &[Step],
    variance: f64,
    samples: f64,
) -> Option<Instants> {
    // Before the recording, an instant is known to be within its interval.
    let known = |step: &Step| variance * 12.0 / (step.interval_s * step.interval_s);
    let levels: Vec<f64> = own
        .iter()
        .zip(steps)
        .map(|(own, step)| own.0 + known(step))
        .collect();
    let mut reduced = gradient;
    let before = information.diagonal();
    for (k, level) in levels.iter().enumerate() {
        let column = cross.column(k);
        information -= column * column.transpose() / *level;
        reduced -= column * (own[k].1 / level);
    }
    let n = information.nrows();
    for i in 0..n {
        // The delay itself, and what has no influence, does not move.
        information[(i, i)] *= 1.0 + SINGULAR;
        if information[(i, i)] <= SINGULAR * before[i] {
            information.row_mut(i).fill(0.0);
            information.column_mut(i).fill(0.0);
            information[(i, i)] = 1.0;
            reduced[i] = 0.0;
        }
    }
    let step = information.cholesky()?.solve(&reduced);
    let shift = |k: usize| (own[k].1 - cross.column(k).dot(&step)) / levels[k];
    let shifts_s: Vec<f64> = (0..own.len()).map(shift).collect();
    Some(Instants {
        information: own.iter().map(|own| own.0).collect(),
        shifts_s,
        samples,
    })
}
