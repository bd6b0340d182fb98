//! The runs: every model on every input of the paper.

use rayon::prelude::*;

use super::{
    models::Model,
    sweep::{self, Point},
};
use crate::{error::Error, settings::Settings, trace::Trace};

/// The inputs of the paper (sections II.A and III), in the order of the report.
pub const INPUTS: [&str; 6] = ["pulse", "variable-step", "ramp", "chirp", "sine", "3-2-1-1"];

/// The runs of one model.
#[derive(Debug, Clone)]
pub struct Runs {
    /// The model.
    pub model: Model,
    /// Its parameters.
    pub settings: Settings,
    /// Its traces in the order of [`INPUTS`], one row per millisecond.
    traces: Vec<Trace>,
    /// Its measured frequency response, in the order of the frequencies.
    pub response: Vec<Point>,
    /// Frequency at which its measured power is half, Hz.
    pub bandwidth_hz: Option<f64>,
}

impl Runs {
    /// The trace on the input of this name.
    pub fn trace(&self, input: &str) -> Option<&Trace> {
        let index = INPUTS.iter().position(|name| *name == input)?;
        self.traces.get(index)
    }
}

/// How often [`run`] calls `done` for this number of models.
pub fn steps(models: usize) -> u64 {
    (models * (INPUTS.len() + sweep::FREQUENCIES_HZ.len() + 1)) as u64
}

/// Runs the models on all cores and calls `done` after each run.
///
/// # Errors
/// Does not fail for [`super::models::MODELS`]; for other models those of
/// [`crate::scenario::Scenario::resolve`].
pub fn run(models: &[Model], done: &(dyn Fn() + Sync)) -> Result<Vec<Runs>, Error> {
    let traces = each(models, &INPUTS, done, |model, input| {
        model.scenario(input).resolve()?.record()
    })?;
    let responses = each(
        models,
        &sweep::FREQUENCIES_HZ,
        done,
        |model, frequency_hz| sweep::measure(model, *frequency_hz),
    )?;
    let of_model = |(i, model): (usize, &Model)| {
        let bandwidth_hz = sweep::bandwidth_hz(model, &responses[i])?;
        done();
        Ok((bandwidth_hz, model.scenario(INPUTS[0]).settings()?))
    };
    let rest: Vec<_> = models
        .par_iter()
        .enumerate()
        .map(of_model)
        .collect::<Result<_, Error>>()?;
    let all = models.iter().zip(traces).zip(responses).zip(rest);
    Ok(all
        .map(
            |(((model, traces), response), (bandwidth_hz, settings))| Runs {
                model: *model,
                settings,
                traces,
                response,
                bandwidth_hz,
            },
        )
        .collect())
}

/// Calls `work` for each model and each of `these` in parallel. The results are in order.
fn each<T: Sync, R: Send>(
    models: &[Model],
    these: &[T],
    done: &(dyn Fn() + Sync),
    work: impl Fn(&Model, &T) -> Result<R, Error> + Sync,
) -> Result<Vec<Vec<R>>, Error> {
    let pairs: Vec<_> = models
        .iter()
        .flat_map(|m| these.iter().map(move |t| (m, t)))
        .collect();
    let one = |(model, this): (&Model, &T)| {
        let result = work(model, this);
        done();
        result
    };
    let results: Vec<R> = pairs.into_par_iter().map(one).collect::<Result<_, _>>()?;
    let mut results = results.into_iter();
    Ok(models
        .iter()
        .map(|_| results.by_ref().take(these.len()).collect())
        .collect())
}
