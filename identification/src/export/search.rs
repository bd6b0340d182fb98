//! Fits the laws of a target to a response.

use std::sync::Arc;

use super::response::Response;
use crate::engine::{Options, Quiet, fit};
use crate::experiment::Experiment;
use crate::loss::{Loss, LossChoice};
use crate::model::Model;
use crate::problem::{IdentifyError, Problem};
use crate::recording::{Hold, Recording};

/// The fit is exact but for rounding: the steps of the search end there, deg rms.
const EXACT_DEG: f64 = 1e-6;

/// A fitted law.
pub(super) struct Found {
    /// Its place among those of the target.
    law: usize,
    /// Its parameters by name, in the order of the law.
    pub values: Vec<(&'static str, f64)>,
    /// The error on the response that it is fitted to, deg rms.
    pub fitted_deg: f64,
}

impl Found {
    /// The error of the law on another response, deg rms; `laws` are those under its setpoint.
    pub fn error_deg(
        &self,
        laws: &[Arc<dyn Model>],
        response: &Response,
        step_s: f64,
    ) -> Result<f64, IdentifyError> {
        let point: Vec<f64> = self.values.iter().map(|(_, value)| *value).collect();
        let run = experiment(response, step_s)?;
        Ok(error_deg(&*laws[self.law], &run, &point))
    }
}

/// The first law that is as good as the best one.
pub(super) fn best(
    laws: &[Arc<dyn Model>],
    response: &Response,
    step_s: f64,
) -> Result<Found, IdentifyError> {
    let run = experiment(response, step_s)?;
    let found: Vec<Found> = laws
        .iter()
        .enumerate()
        .map(|(index, law)| one(index, law, &run))
        .collect::<Result<_, _>>()?;
    let errors = found.iter().map(|f| f.fitted_deg);
    let least = errors.fold(f64::INFINITY, f64::min);
    let is_as_good = |f: &Found| f.fitted_deg <= 1.01 * least + EXACT_DEG;
    let mut simplest = found.into_iter().filter(is_as_good);
    simplest.next().ok_or(IdentifyError::NotFinite)
}

/// The response as a recording.
fn experiment(response: &Response, step_s: f64) -> Result<Experiment, IdentifyError> {
    let recording = Recording {
        name: "response".into(),
        time_s: (0..response.angle_deg.len())
            .map(|step| step as f64 * step_s)
            .collect(),
        command_deg: response.target_deg.to_vec(),
        angle_deg: response.angle_deg.clone(),
        hold: Hold::Zero,
        ..Default::default()
    };
    Experiment::try_new(recording).map_err(|error| IdentifyError::Recording {
        name: "response".into(),
        error,
    })
}

/// What is known of a law: it begins at rest at zero, the setpoint is what it is to reach, and its
/// own limits are out of reach.
const KNOWN: [(&str, f64); 6] = [
    ("gain", 1.0),
    ("offset_deg", 0.0),
    ("initial_angle_deg", 0.0),
    ("initial_rate_deg_s", 0.0),
    ("rate_limit_up_deg_s", 1e5),
    ("rate_limit_down_deg_s", 1e5),
];

/// Fits one law; a delay in steps becomes a whole number.
fn one(index: usize, law: &Arc<dyn Model>, run: &Experiment) -> Result<Found, IdentifyError> {
    let mut problem = Problem::try_new(law.clone(), vec![run.clone()])?;
    for (name, value) in KNOWN {
        if law.parameter_index(name).is_some() {
            problem.fix(name, value)?;
        }
    }
    let mut best = solve(&problem)?;
    if let Some(delay) = law.parameter_index("delay_steps") {
        let point = best.0;
        best = (Vec::new(), f64::INFINITY);
        for steps in [point[delay].floor(), point[delay].ceil()] {
            for (spec, value) in problem.specs.iter_mut().zip(&point) {
                spec.start = *value;
            }
            problem.fix("delay_steps", steps)?;
            let found = solve(&problem)?;
            if found.1 < best.1 {
                best = found;
            }
        }
    }
    let (point, fitted_deg) = best;
    if !fitted_deg.is_finite() {
        return Err(IdentifyError::NotFinite);
    }
    let names = law.parameters().iter().map(|p| p.name);
    Ok(Found {
        law: index,
        values: names.zip(point).collect(),
        fitted_deg,
    })
}

/// The optimum, and its error, deg rms.
fn solve(problem: &Problem) -> Result<(Vec<f64>, f64), IdentifyError> {
    let options = Options {
        loss: LossChoice::Given(Loss::Squares),
        ..Options::default()
    };
    let fit = fit(problem, &options, &Quiet)?;
    let names = problem.model.parameters().iter().map(|p| p.name);
    let point: Vec<f64> = names
        .map(|name| fit.value(name).unwrap_or(f64::NAN))
        .collect();
    let error_deg = error_deg(&*problem.model, &problem.experiments[0], &point);
    Ok((point, error_deg))
}

/// The error of a law on a response, deg rms.
fn error_deg(law: &dyn Model, run: &Experiment, point: &[f64]) -> f64 {
    let mut squares = 0.0;
    law.simulate(run, point, &mut |i, sample| {
        squares += (sample.angle_deg - run.recording.angle_deg[i]).powi(2);
    });
    (squares / run.len() as f64).sqrt()
}
