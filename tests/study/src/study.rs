//! Evaluation of the runs: the fits, their predictions, and the sufficient model.

use std::collections::BTreeMap;

use identification::{
    Experiment,
    compare::{Candidate, Comparison},
};
use rayon::prelude::*;

use crate::{
    Failure,
    models::{Fitted, MODELS, known, model, search},
    runs::{CONDITIONS, INPUTS, Run, SampleRate, progress},
};

/// Identification of a fit: sample rate, and indices of condition, input and model.
pub type FitKey = (usize, SampleRate, usize, usize);

/// The study.
#[derive(Debug)]
pub struct Study {
    /// All runs.
    pub runs: Vec<Run>,
    /// All fits.
    pub fits: BTreeMap<FitKey, Fitted>,
    /// The sufficient model of each condition, in words.
    pub verdicts: Vec<String>,
}

/// Number of runs that the models are fitted to in the comparison; the others are for validation.
const FITTED_RUNS: u64 = 3;

impl Study {
    /// Fits everything.
    ///
    /// # Errors
    /// The first failure.
    pub fn of(runs: Vec<Run>) -> Result<Self, Failure> {
        let mut keys = Vec::new();
        for condition in 0..CONDITIONS.len() {
            for rate in SampleRate::ALL {
                for input in 0..INPUTS.len() {
                    keys.extend((0..MODELS.len()).map(|model| (condition, rate, input, model)));
                }
            }
        }
        let has_runs = |key: &FitKey| of_input(&runs, key.0, key.2).next().is_some();
        keys.retain(has_runs);
        let bar = progress(keys.len() + CONDITIONS.len(), "fits");
        let one = |key: &FitKey| {
            let fitted = fit(&runs, *key)?;
            bar.inc(1);
            Ok((*key, fitted))
        };
        let fits = keys.par_iter().map(one);
        let fits = fits.collect::<Result<BTreeMap<_, _>, Failure>>()?;
        let mut verdicts = Vec::new();
        for condition in 0..CONDITIONS.len() {
            verdicts.push(sufficient_model(&runs, condition)?);
            bar.inc(1);
        }
        bar.finish_and_clear();
        Ok(Self {
            runs,
            fits,
            verdicts,
        })
    }

    /// The runs of an input.
    pub fn runs(&self, condition: usize, input: &str) -> Vec<&Run> {
        of_input(&self.runs, condition, input_index(input)).collect()
    }

    /// A fit.
    pub fn fit(
        &self,
        condition: usize,
        rate: SampleRate,
        input: &str,
        model: usize,
    ) -> Option<&Fitted> {
        self.fits.get(&(condition, rate, input_index(input), model))
    }
}

/// Index of an input in [`INPUTS`].
pub fn input_index(input: &str) -> usize {
    INPUTS.iter().position(|name| *name == input).unwrap_or(0)
}

fn of_input(runs: &[Run], condition: usize, input: usize) -> impl Iterator<Item = &Run> {
    let (controller, load) = CONDITIONS[condition];
    runs.iter().filter(move |run| {
        (run.key.controller, run.key.load, run.key.input) == (controller, load, input)
    })
}

fn experiments<'a>(
    runs: impl Iterator<Item = &'a Run>,
    rate: SampleRate,
) -> Result<Vec<Experiment>, Failure> {
    runs.map(|run| run.experiment(rate)).collect()
}

fn fit(runs: &[Run], (condition, rate, input, model): FitKey) -> Result<Fitted, Failure> {
    let own = experiments(of_input(runs, condition, input), rate)?;
    // The prediction of other inputs does not depend on the rate: the lower rate takes less time.
    let others = match rate {
        SampleRate::Hz250 => Vec::new(),
        SampleRate::Hz50 => (0..INPUTS.len())
            .map(|other| experiments(of_input(runs, condition, other), rate))
            .collect::<Result<_, _>>()?,
    };
    Fitted::of(model, CONDITIONS[condition].0, &own, &others)
}

/// Fits all models to some runs of all inputs together, and ranks them by the other runs.
fn sufficient_model(runs: &[Run], condition: usize) -> Result<String, Failure> {
    let of_all = || (0..INPUTS.len()).flat_map(|input| of_input(runs, condition, input));
    let fitted = of_all().filter(|run| run.key.run <= FITTED_RUNS);
    let held_out = of_all().filter(|run| run.key.run > FITTED_RUNS);
    let fitted = experiments(fitted, SampleRate::Hz50)?;
    let held_out = experiments(held_out, SampleRate::Hz50)?;
    if fitted.is_empty() || held_out.is_empty() {
        return Ok(String::from("too few runs to compare the models"));
    }
    let candidate = |index: usize| {
        Ok(Candidate {
            name: MODELS[index].into(),
            model: model(index)?,
            held: known(index, CONDITIONS[condition].0),
        })
    };
    let candidates: Vec<Candidate> = (0..MODELS.len())
        .map(candidate)
        .collect::<Result<_, Failure>>()?;
    let comparison = Comparison::of(&candidates, &fitted, &held_out, &search(), &|_| {})?;
    let reasons = comparison.ranking.ranks.iter().map(|rank| {
        let name = &comparison.assessments[rank.index].name;
        format!("{name} {:.2} deg ({})", rank.score, rank.reason)
    });
    let reasons: Vec<String> = reasons.collect();
    Ok(format!(
        "{}. {}.",
        comparison.ranking.verdict,
        reasons.join("; ")
    ))
}
