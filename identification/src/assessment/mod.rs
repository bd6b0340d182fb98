//! The assessment of a fit: quality, residuals, limits, validation, and warnings.

pub mod limited;
pub mod nonparametric;
mod warnings;

use std::sync::Arc;

pub use limited::{Limited, Stretch};
pub use nonparametric::NonparametricAnalysis;

use super::{
    engine::predict,
    experiment::Experiment,
    fit::{ExperimentFit, Fit},
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
        let fitted = problem.experiments.iter().zip(&fit.experiments);
        let assessed = |(experiment, fit): (&Experiment, &ExperimentFit)| {
            Assessed::of(experiment.recording.clone(), fit.clone())
        };
        let experiments: Vec<Assessed> = fitted.map(assessed).collect();
        let predicted = |experiment: &Experiment| {
            let fit = predict(problem, &fit, experiment)?;
            Ok(Assessed::of(experiment.recording.clone(), fit))
        };
        let validation = held_out
            .iter()
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
            validation,
            effective_samples,
            warnings: Vec::new(),
            fit,
        };
        this.warnings = warnings::all(&this);
        Ok(this)
    }

    /// Number of estimated parameters.
    pub fn unknowns(&self) -> usize {
        self.fit.estimates.iter().filter(|e| !e.fixed).count()
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
