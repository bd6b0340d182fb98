//! The assessment of a fit: quality, residuals, limits, validation, and warnings.

mod extrapolation;
mod instants;
pub mod nonparametric;
mod warnings;

use std::sync::Arc;

use rayon::prelude::*;

pub use crate::limited::{Limited, Stretch};
pub use nonparametric::NonparametricAnalysis;

use super::{
    engine::predict,
    experiment::Experiment,
    experiment_fit::ExperimentFit,
    fit::{Bound, Estimate, Fit},
    problem::{IdentifyError, Problem},
    recording::Recording,
    statistics::{Correlations, Criteria, Quality},
};

/// A model's fit to one recording, with the analysis of its residuals.
#[derive(Debug, Clone)]
pub struct Assessed {
    /// The recording.
    pub recording: Arc<Recording>,
    /// The fit or prediction.
    pub fit: ExperimentFit,
    /// Figures of merit; `None` without residuals.
    pub quality: Option<Quality>,
    /// Correlations of the residuals; `None` where they are all equal.
    pub correlations: Option<Correlations>,
    /// The time at each limit.
    pub limited: Limited,
}

impl Assessed {
    fn of(recording: Arc<Recording>, fit: ExperimentFit) -> Self {
        let (time_s, command) = (&recording.time_s, &recording.command_deg);
        Self {
            quality: Quality::of(&recording.angle_deg, &fit.predicted_deg),
            correlations: Correlations::of(time_s, &fit.residual_deg, command),
            limited: Limited::of(time_s, &fit.state),
            recording,
            fit,
        }
    }
}

/// A fit with its assessment.
#[derive(Debug, Clone)]
pub struct Assessment {
    /// The model's name, with the effects that were left out.
    pub name: String,
    /// The fit.
    pub fit: Fit,
    /// The recordings that it was fitted to.
    pub experiments: Vec<Assessed>,
    /// The held-out recordings, of which only the initial state was estimated.
    pub validation: Vec<Assessed>,
    /// Information criteria.
    pub criteria: Criteria,
    /// The number of independent residuals.
    pub effective_samples: f64,
    /// Warnings.
    pub warnings: Vec<String>,
    /// Those of the warnings that say why the intervals of the estimates may not cover the true
    /// values.
    pub doubts: Vec<String>,
}

impl Assessment {
    /// Assesses a fit, and predicts the held-out recordings.
    ///
    /// # Errors
    /// Those of [`predict`].
    pub fn of(
        name: impl Into<String>,
        problem: &Problem,
        fit: Fit,
        held_out: &[Experiment],
    ) -> Result<Self, IdentifyError> {
        let fitted = problem.experiments.par_iter().zip(&fit.experiments);
        let assessed = |(experiment, fit): (&Experiment, &ExperimentFit)| {
            Assessed::of(experiment.recording.clone(), fit.clone())
        };
        let experiments: Vec<Assessed> = fitted.map(assessed).collect();
        let predicted = |experiment: &Experiment| {
            let fit = predict(problem, &fit, experiment)?;
            Ok(Assessed::of(experiment.recording.clone(), fit))
        };
        let validation = held_out
            .par_iter()
            .map(predicted)
            .collect::<Result<_, IdentifyError>>()?;
        let known = experiments.iter().filter_map(|e| e.correlations.as_ref());
        let effective: f64 = known.map(|c| c.effective_samples).sum();
        let unknowns = fit.estimates.iter().filter(|e| !e.fixed).count();
        // Without correlated residuals all samples are independent.
        let effective_samples = if effective > 0.0 {
            effective
        } else {
            fit.samples as f64
        };
        let mut this = Self {
            name: name.into(),
            criteria: Criteria::new(fit.samples, 2.0 * fit.cost, unknowns),
            experiments,
            validation: Vec::new(),
            effective_samples,
            warnings: Vec::new(),
            doubts: Vec::new(),
            fit,
        };
        this.doubts = warnings::doubts(&this);
        this.warnings = warnings::all(&this);
        this.add_validation(validation, (&problem.experiments, held_out));
        Ok(this)
    }

    /// Adds predictions of held-out recordings by a fit to other ones.
    pub fn add_validation(
        &mut self,
        predicted: Vec<Assessed>,
        (fitted, held_out): (&[Experiment], &[Experiment]),
    ) {
        if !held_out.is_empty() {
            let beyond = extrapolation::warnings(fitted, held_out);
            self.warnings.extend(beyond);
        }
        self.validation.extend(predicted);
    }

    /// What limits the use of an estimate: the same words in all tables and files.
    pub fn remark(&self, estimate: &Estimate) -> &'static str {
        match (estimate.at_bound, estimate.identifiable) {
            _ if estimate.fixed => "given",
            (Some(Bound::Low), true) => "at its lower bound",
            (Some(Bound::High), true) => "at its upper bound",
            (Some(Bound::Low), false) => "at its lower bound: not identifiable",
            (Some(Bound::High), false) => "at its upper bound: not identifiable",
            (None, false) => "not identifiable",
            (None, true) if !self.doubts.is_empty() => "its interval may not hold",
            (None, true) => "",
        }
    }

    /// Number of estimated parameters.
    pub fn unknowns(&self) -> usize {
        self.fit.estimates.iter().filter(|e| !e.fixed).count()
    }
}

/// Points from each model with coloured residuals to one that explains them: the first other with
/// white residuals, or else the one with the least cost, if it is below half.
pub fn point_to_better(assessments: &mut [Assessment]) {
    let is_white = |a: &Assessment| {
        let mut all = a.experiments.iter().filter_map(|e| e.correlations.as_ref());
        all.all(|c| c.whiteness.is_white())
    };
    let white = assessments.iter().find(|a| is_white(a));
    let white = white.map(|a| (a.name.clone(), a.fit.cost));
    let by_cost = |a: &&Assessment, b: &&Assessment| a.fit.cost.total_cmp(&b.fit.cost);
    let least = assessments.iter().min_by(by_cost);
    let least = least.map(|a| (a.name.clone(), a.fit.cost));
    for assessment in assessments.iter_mut().filter(|a| !is_white(a)) {
        let cost = assessment.fit.cost;
        if let Some((name, _)) = white.as_ref().filter(|(_, other)| *other < cost) {
            assessment.warnings.push(format!(
                "{name} explains what the residuals contain: its own are white"
            ));
        } else if let Some((name, _)) = least.as_ref().filter(|(_, other)| *other < 0.5 * cost) {
            assessment.warnings.push(format!(
                "{name} explains more than half of the residuals, though its own are not white"
            ));
        }
    }
}

/// Figures of merit over several recordings together; `None` without residuals.
pub fn overall(assessed: &[Assessed]) -> Option<Quality> {
    let column = |of: &dyn Fn(&Assessed) -> Vec<f64>| assessed.iter().flat_map(of).collect();
    let measured: Vec<f64> = column(&|a| a.recording.angle_deg.clone());
    let predicted: Vec<f64> = column(&|a| a.fit.predicted_deg.clone());
    Quality::of(&measured, &predicted)
}

#[cfg(test)]
mod tests;
