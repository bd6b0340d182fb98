//! A fit with everything that a specialist asks of it: quality, residuals, limits, validation, and
//! what speaks against it in words.

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

/// What a model makes of one recording, and what the residuals tell.
#[derive(Debug, Clone)]
pub struct Assessed {
    /// The recording.
    pub recording: Arc<Recording>,
    /// The model's answer.
    pub fit: ExperimentFit,
    /// How near it comes; `None` where nothing was compared.
    pub quality: Option<Quality>,
    /// What is left in the residuals; `None` where there is nothing left.
    pub correlations: Option<Correlations>,
    /// How long the model was at which limit.
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

/// A fit, assessed.
#[derive(Debug, Clone)]
pub struct Assessment {
    /// How it is called: the model's name, and what was left out of it.
    pub name: String,
    /// The fit.
    pub fit: Fit,
    /// Each recording that it was fitted to.
    pub experiments: Vec<Assessed>,
    /// Each recording that was left out of the fit; its initial state alone was looked for.
    pub validation: Vec<Assessed>,
    /// Information criteria.
    pub criteria: Criteria,
    /// As many residuals as are independent of each other.
    pub effective_samples: f64,
    /// What speaks against it or must be known of it.
    pub warnings: Vec<String>,
}

impl Assessment {
    /// Assesses a fit, and predicts recordings that it has not seen.
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
        // A fit without residuals has as many samples as it has.
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

    /// Number of parameters that were looked for.
    pub fn unknowns(&self) -> usize {
        self.fit.estimates.iter().filter(|e| !e.fixed).count()
    }
}

/// Quality over several recordings as one; `None` where nothing was compared.
pub fn overall(assessed: &[Assessed]) -> Option<Quality> {
    let column = |of: &dyn Fn(&Assessed) -> Vec<f64>| assessed.iter().flat_map(of).collect();
    let measured: Vec<f64> = column(&|a| a.recording.angle_deg.clone());
    let predicted: Vec<f64> = column(&|a| a.fit.predicted_deg.clone());
    Quality::of(&measured, &predicted)
}

#[cfg(test)]
mod tests;
