//! Compares models, with and without delay and limits, and selects the simplest sufficient one.

mod ranking;

use std::{cmp::Reverse, sync::Arc};

pub use ranking::{Rank, Ranking};

use super::{
    assessment::{Assessment, point_to_better},
    engine::{Options, Quiet, fit_from},
    experiment::Experiment,
    fit::Fit,
    loss::{Loss, LossChoice},
    model::{Model, ModelParameter},
    problem::{IdentifyError, Problem},
};

/// A model, with the effects that are left out.
#[derive(Clone)]
pub struct Candidate {
    /// Its name, such as `black-box-1 without delay`.
    pub name: String,
    /// The model.
    pub model: Arc<dyn Model>,
    /// Parameters that are fixed, each at the value at which it has no effect.
    pub held: Vec<(&'static str, f64)>,
}

/// No delay.
const NO_DELAY: [(&str, f64); 1] = [("delay_s", 0.0)];
/// The rate limits, which are removed by an infinite value or by the upper bound of the search.
const NO_LIMITS: [&str; 2] = ["rate_limit_up_deg_s", "rate_limit_down_deg_s"];

impl Candidate {
    /// All variants of a model: complete, without delay, without rate limits, without both.
    /// Variants without an effect that the model does not have, or that it fixes, are omitted.
    pub fn forms(model: &Arc<dyn Model>) -> Vec<Self> {
        let parameters = model.parameters();
        let free = |name: &str| parameters.iter().find(|p| p.name == name && !p.is_fixed);
        let delay: Vec<_> = NO_DELAY
            .into_iter()
            .filter(|(name, _)| free(name).is_some())
            .collect();
        let limits: Vec<_> = NO_LIMITS
            .into_iter()
            .filter_map(|name| Some((name, unlimited(free(name)?))))
            .collect();
        let mut forms = vec![(String::new(), Vec::new())];
        if !delay.is_empty() {
            forms.push((" without delay".into(), delay.clone()));
        }
        if !limits.is_empty() {
            forms.push((" without rate limits".into(), limits.clone()));
        }
        if !delay.is_empty() && !limits.is_empty() {
            let both = [delay, limits].concat();
            forms.push((" without delay and rate limits".into(), both));
        }
        let candidate = |(form, held): (String, Vec<(&'static str, f64)>)| Self {
            name: format!("{}{form}", model.name()),
            model: model.clone(),
            held,
        };
        forms.into_iter().map(candidate).collect()
    }

    /// Fits and assesses it.
    ///
    /// # Errors
    /// Those of [`Problem::try_new`] and of [`fit_from`].
    fn assess(
        &self,
        (experiments, held_out): (&[Experiment], &[Experiment]),
        options: &Options,
        known: &[&Fit],
    ) -> Result<Assessment, IdentifyError> {
        let mut problem = Problem::try_new(self.model.clone(), experiments.to_vec())?;
        for (name, value) in &self.held {
            problem.fix(name, *value)?;
        }
        let fitted = fit_from(&problem, options, &Quiet, known)?;
        Assessment::of(self.name.clone(), &problem, fitted, held_out)
    }

    /// Whether the optimum of another candidate is a starting point of this one: of the same model
    /// with more left out, or of another model with the same left out.
    fn may_begin_at(&self, other: &Self) -> bool {
        let is_held = |(name, _): &(&str, f64)| other.held.iter().any(|(held, _)| held == name);
        let is_more = other.held.len() > self.held.len();
        let is_own = other.model.name() == self.model.name();
        self.held.iter().all(is_held) && is_own == is_more
    }
}

/// The order of fitting: the simpler variants of a model first, the models in their order.
fn simple_first(candidates: &[Candidate]) -> Vec<usize> {
    let place = |candidate: &Candidate| {
        let is_it = |other: &Candidate| other.model.name() == candidate.model.name();
        candidates.iter().position(is_it)
    };
    let mut order: Vec<usize> = (0..candidates.len()).collect();
    order.sort_by_key(|&i| (place(&candidates[i]), Reverse(candidates[i].held.len())));
    order
}

/// The value at which a limit has no effect.
fn unlimited(limit: &ModelParameter) -> f64 {
    if limit.default.is_infinite() {
        f64::INFINITY
    } else {
        limit.max
    }
}

/// The name of a candidate that could not be fitted, with the reason.
pub type Refused = (String, IdentifyError);

/// Models that were fitted to the same recordings.
pub struct Comparison {
    /// The fits, in the order of the candidates.
    pub assessments: Vec<Assessment>,
    /// Candidates that could not be fitted, each with the reason.
    pub refused: Vec<Refused>,
    /// Their ranking.
    pub ranking: Ranking,
}

/// The outcome of each candidate: its assessment, or the reason why it is refused.
type Outcome = Result<Assessment, Refused>;

/// The criterion of [`Comparison::leave_one_out`].
const LEFT_OUT: &str =
    "root mean square error on each recording, predicted by the fit to all others (deg)";

impl Comparison {
    /// Fits all candidates, and reports the number of finished ones. A candidate that cannot be
    /// fitted is listed as refused. Where outliers call for a robust loss in one of them, all are
    /// fitted with it, so that their costs can be compared.
    ///
    /// # Errors
    /// That of the first candidate, if no candidate can be fitted.
    pub fn of(
        candidates: &[Candidate],
        experiments: &[Experiment],
        held_out: &[Experiment],
        options: &Options,
        progress: &dyn Fn(usize),
    ) -> Result<Self, IdentifyError> {
        Self::ranked(outcomes(
            candidates,
            experiments,
            held_out,
            options,
            progress,
        ))
    }

    /// Fits all candidates to all recordings, and ranks them by cross-validation: each recording is
    /// predicted by the fit to all others, and is a held-out one of the assessments. Reports the
    /// number of finished fits, of [`Comparison::leave_one_out_fits`]. A candidate is refused that
    /// cannot be fitted to all recordings, or without one of them.
    ///
    /// # Errors
    /// That of the first candidate, if no candidate can be fitted.
    pub fn leave_one_out(
        candidates: &[Candidate],
        experiments: &[Experiment],
        options: &Options,
        progress: &dyn Fn(usize),
    ) -> Result<Self, IdentifyError> {
        let mut all = outcomes(candidates, experiments, &[], options, progress);
        for (index, left_out) in experiments.iter().enumerate() {
            let others = [&experiments[..index], &experiments[index + 1..]].concat();
            let held_out = std::slice::from_ref(left_out);
            let before = (index + 1) * candidates.len();
            let progress = |done| progress(before + done);
            let fold = outcomes(candidates, &others, held_out, options, &progress);
            for (outcome, predicted) in all.iter_mut().zip(fold) {
                let Ok(assessment) = outcome else { continue };
                match predicted {
                    Ok(predicted) => {
                        assessment.add_validation(predicted.validation, (&others, held_out));
                    }
                    Err((name, error)) => {
                        let name = format!("{name} (fitted without {})", left_out.recording.name);
                        *outcome = Err((name, error));
                    }
                }
            }
        }
        let mut comparison = Self::ranked(all)?;
        comparison.ranking.criterion = LEFT_OUT;
        Ok(comparison)
    }

    /// The number of fits of [`Comparison::leave_one_out`].
    pub fn leave_one_out_fits(candidates: usize, experiments: usize) -> usize {
        candidates * (experiments + 1)
    }

    fn ranked(outcomes: Vec<Outcome>) -> Result<Self, IdentifyError> {
        let (mut assessments, mut refused) = (Vec::new(), Vec::new());
        for outcome in outcomes {
            match outcome {
                Ok(assessment) => assessments.push(assessment),
                Err(refusal) => refused.push(refusal),
            }
        }
        if assessments.is_empty() {
            let first = refused.into_iter().next();
            return Err(first.map_or(IdentifyError::NoRecording, |(_, error)| error));
        }
        point_to_better(&mut assessments);
        Ok(Self {
            ranking: Ranking::of(&assessments),
            assessments,
            refused,
        })
    }
}

/// Fits all candidates with one loss, and predicts the held-out recordings.
fn outcomes(
    candidates: &[Candidate],
    experiments: &[Experiment],
    held_out: &[Experiment],
    options: &Options,
    progress: &dyn Fn(usize),
) -> Vec<Outcome> {
    let outcomes = outcomes_with_loss(candidates, experiments, held_out, options, progress);
    let losses = outcomes.iter().flatten().map(|a| a.fit.loss);
    let scales = losses.filter_map(|loss| match loss {
        Loss::Student { scale_deg } => Some(scale_deg),
        Loss::Squares => None,
    });
    let Some(scale_deg) = scales.min_by(f64::total_cmp) else {
        return outcomes;
    };
    let options = Options {
        loss: LossChoice::Given(Loss::Student { scale_deg }),
        ..*options
    };
    outcomes_with_loss(candidates, experiments, held_out, &options, progress)
}

/// The same with the loss of the options.
fn outcomes_with_loss(
    candidates: &[Candidate],
    experiments: &[Experiment],
    held_out: &[Experiment],
    options: &Options,
    progress: &dyn Fn(usize),
) -> Vec<Outcome> {
    let mut outcomes: Vec<Option<Outcome>> = Vec::new();
    outcomes.resize_with(candidates.len(), || None);
    for (done, index) in simple_first(candidates).into_iter().enumerate() {
        let candidate = &candidates[index];
        let others = candidates.iter().zip(&outcomes);
        let known = others.filter_map(|(other, outcome)| match outcome {
            Some(Ok(assessment)) if candidate.may_begin_at(other) => Some(&assessment.fit),
            _ => None,
        });
        let known: Vec<&Fit> = known.collect();
        let assessed = candidate.assess((experiments, held_out), options, &known);
        outcomes[index] = Some(assessed.map_err(|error| (candidate.name.clone(), error)));
        progress(done + 1);
    }
    outcomes.into_iter().flatten().collect()
}

#[cfg(test)]
mod tests;
