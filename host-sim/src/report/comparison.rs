//! All models, what they did and what is made of it.

use serde::Serialize;
use std::collections::BTreeMap;

use super::{
    metrics::Metrics,
    models::{BASELINE, Family, Model},
    runs::{self, INPUTS, Runs},
    small_signal::SmallSignal,
};
use crate::{error::Error, plot::Style};

/// What came out for one model.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// What it did.
    pub runs: Runs,
    /// Its linear model, where it has one.
    pub linear: Option<SmallSignal>,
    /// Its figures of merit.
    pub metrics: Metrics,
    /// How far its angle is from that of [`BASELINE`], root mean square, deg, by input; empty
    /// without a baseline.
    pub rms_difference_deg: BTreeMap<&'static str, f64>,
}

/// The outcome for several models on all inputs.
#[derive(Debug, Clone)]
pub struct Comparison {
    /// One a model, in the order in which they were given.
    pub outcomes: Vec<Outcome>,
}

impl Comparison {
    /// How often `done` is called for so many models.
    pub fn steps(models: usize) -> u64 {
        runs::steps(models)
    }

    /// Runs the models on all cores; `done` is called after each run. The result depends on the
    /// models alone.
    ///
    /// # Errors
    /// None of [`super::models::MODELS`]; else those of [`crate::scenario::Scenario::resolve`].
    pub fn of(models: &[Model], done: &(dyn Fn() + Sync)) -> Result<Self, Error> {
        let all = runs::run(models, done)?;
        let baseline = all.iter().find(|runs| runs.model.name == BASELINE).cloned();
        let outcome = |runs: Runs| {
            let linear = SmallSignal::of(&runs.settings)?;
            let difference =
                |input| Some((input, rms_difference_deg(&runs, baseline.as_ref()?, input)?));
            Ok(Outcome {
                metrics: Metrics::of(&runs, linear.as_ref()),
                rms_difference_deg: INPUTS.into_iter().filter_map(difference).collect(),
                linear,
                runs,
            })
        };
        let outcomes = all.into_iter().map(outcome).collect::<Result<_, Error>>()?;
        Ok(Self { outcomes })
    }

    /// What is drawn together: the paper's models with the board, and each family with readings.
    pub fn groups(&self) -> [(&'static str, Vec<&Outcome>); 3] {
        let leading = self.outcomes.iter().filter(|o| o.runs.model.leads);
        let family_of = |family| {
            let outcomes = self.outcomes.iter();
            dashed_last(outcomes.filter(|o| o.runs.model.family == family))
        };
        [
            ("the paper's models and the board", leading.collect()),
            ("readings of the grey box", family_of(Family::GreyBox)),
            ("boards", family_of(Family::Board)),
        ]
    }

    /// All of them.
    pub fn all(&self) -> Vec<&Outcome> {
        dashed_last(self.outcomes.iter())
    }

    /// All figures of the tables as JSON; `null` is what does not exist.
    pub fn to_json(&self) -> String {
        let models = self.outcomes.iter().map(|o| JsonModel {
            name: o.runs.model.name,
            preset: o.runs.model.preset,
            inputs: INPUTS,
            metrics: &o.metrics,
            rms_difference_deg: &o.rms_difference_deg,
        });
        let report = JsonReport {
            baseline: BASELINE,
            models: models.collect(),
        };
        // Strings, numbers and maps of strings always serialise.
        serde_json::to_string_pretty(&report).unwrap_or_default() + "\n"
    }
}

/// In the order of drawing: what is dashed lets what it covers be seen.
fn dashed_last<'a>(outcomes: impl Iterator<Item = &'a Outcome>) -> Vec<&'a Outcome> {
    let mut outcomes: Vec<_> = outcomes.collect();
    outcomes.sort_by_key(|outcome| outcome.runs.model.style == Style::Dashed);
    outcomes
}

#[derive(Serialize)]
struct JsonReport<'a> {
    baseline: &'a str,
    models: Vec<JsonModel<'a>>,
}

#[derive(Serialize)]
struct JsonModel<'a> {
    name: &'a str,
    preset: &'a str,
    inputs: [&'a str; 6],
    metrics: &'a Metrics,
    rms_difference_deg: &'a BTreeMap<&'static str, f64>,
}

fn rms_difference_deg(runs: &Runs, baseline: &Runs, input: &str) -> Option<f64> {
    let angle = |runs: &Runs| Some(runs.trace(input)?.column("angle_deg")?.to_vec());
    let (ours, theirs) = (angle(runs)?, angle(baseline)?);
    let squares = ours.iter().zip(&theirs).map(|(a, b)| (a - b) * (a - b));
    Some((squares.sum::<f64>() / ours.len() as f64).sqrt())
}
