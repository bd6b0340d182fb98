//! The runs of all models and their evaluation.

use serde::Serialize;
use std::collections::BTreeMap;

use super::{
    metrics::Metrics,
    models::{BASELINE, Family, Model},
    runs::{self, INPUTS, Runs},
    small_signal::SmallSignal,
};
use crate::{error::Error, plot::Style};

/// The results of one model.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// Its runs.
    pub runs: Runs,
    /// Its linear model, if it has one.
    pub linear: Option<SmallSignal>,
    /// Its figures of merit.
    pub metrics: Metrics,
    /// Root mean square of the difference to the angle of [`BASELINE`], deg, by input; empty
    /// without a baseline.
    pub rms_difference_deg: BTreeMap<&'static str, f64>,
}

/// The results of several models on all inputs.
#[derive(Debug, Clone)]
pub struct Comparison {
    /// One for each model, in the given order.
    pub outcomes: Vec<Outcome>,
}

impl Comparison {
    /// How often [`Comparison::of`] calls `done` for this number of models.
    pub fn steps(models: usize) -> u64 {
        runs::steps(models)
    }

    /// Runs the models on all cores and calls `done` after each run. The result does not depend on
    /// the order of the runs.
    ///
    /// # Errors
    /// Does not fail for [`super::models::MODELS`]; for other models those of
    /// [`crate::scenario::Scenario::resolve`].
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

    /// The groups of models that share a figure: the paper's models with the board, the
    /// interpretations of the grey box, and the boards.
    pub fn groups(&self) -> [(&'static str, Vec<&Outcome>); 3] {
        let leading = self.outcomes.iter().filter(|o| o.runs.model.leads);
        let family_of = |family| {
            let outcomes = self.outcomes.iter();
            dashed_last(outcomes.filter(|o| o.runs.model.family == family))
        };
        [
            ("the paper's models and the board", leading.collect()),
            (
                "interpretations of the grey box",
                family_of(Family::GreyBox),
            ),
            ("boards", family_of(Family::Board)),
        ]
    }

    /// All results in drawing order.
    pub fn all(&self) -> Vec<&Outcome> {
        dashed_last(self.outcomes.iter())
    }

    /// The figures of merit as JSON. A value that does not exist is `null`.
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
        // Serialising strings, numbers and maps of strings does not fail.
        serde_json::to_string_pretty(&report).unwrap_or_default() + "\n"
    }
}

/// In drawing order: dashed lines last, so that the lines below them remain visible.
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
