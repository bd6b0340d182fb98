//! Experiment design: the precision of the estimates that an input will give.
//!
//! For expected parameters, noise and sampling, the inverse of the Fisher information bounds the
//! covariance of any unbiased estimator: the Cramer-Rao bound (Maine and Iliff, NASA RP-1138,
//! chapter 11; Jategaonkar, Flight Vehicle System Identification, chapter 2). For output error with
//! white noise it is `sigma^2 (J' J)^-1`, `J` being the sensitivities of the angle.

pub mod inputs;

use std::sync::Arc;

use model_core::{
    control::encoder_word::COUNT_DEG,
    excitation::{Excitation, catalogue::Input},
    time::{CONTROL_PERIOD_S, TICKS_PER_SECOND, ticks},
};
use nalgebra::DMatrix;

use super::{
    assessment::Limited,
    engine::normal_equations,
    experiment::Experiment,
    model::{ActiveLimit, Model, Sample},
    observable::{Observable, weight},
    problem::{IdentifyError, Problem, Role},
    recording::{Hold, Recording},
    unknowns::Unknowns,
};

/// The expected actuator and the measurement.
#[derive(Clone)]
pub struct ExperimentSetup {
    /// The model to be fitted.
    pub model: Arc<dyn Model>,
    /// Its expected parameter values.
    pub values: Vec<f64>,
    /// Which of them will be estimated.
    pub free: Vec<bool>,
    /// Standard errors of the values that will be held as known from elsewhere, each in the unit of
    /// its parameter: what they change in the estimates is a part of the predicted errors. A value
    /// without one, or with one that is not above zero, is exact.
    pub held: Vec<Option<f64>>,
    /// Standard deviation of the noise on the angle, deg.
    pub noise_deg: f64,
    /// Resolution of the encoder, deg; 0 for none.
    pub resolution_deg: f64,
    /// Time from sample to sample, s.
    pub step_s: f64,
    /// Length of the experiment, s.
    pub duration_s: f64,
}

/// Resolution of the actuator's own encoder, deg.
pub const ENCODER_DEG: f64 = COUNT_DEG;

/// The predicted result of an input.
#[derive(Debug, Clone, PartialEq)]
pub struct Prediction {
    /// The estimated parameters, each with its Cramer-Rao standard error; `None` where the input
    /// does not distinguish it from the others.
    pub parameters: Vec<Predicted>,
    /// The time that the actuator will be at its limits.
    pub limited: Limited,
    /// The largest angle that the actuator will reach, deg.
    pub largest_angle_deg: f64,
}

/// The predicted precision of a parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Predicted {
    /// Its name.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Its expected value.
    pub value: f64,
    /// Its Cramer-Rao standard error.
    pub standard_error: Option<f64>,
    /// Whether zero is a usual value, as of an offset: a share of it says little.
    pub is_usually_zero: bool,
}

impl Predicted {
    /// The relative standard error, %; `None` for a usual zero that is smaller than its error.
    pub fn percent(&self) -> Option<f64> {
        let percent = 100.0 * self.standard_error? / self.value.abs();
        (percent <= 100.0 || !self.is_usually_zero).then_some(percent)
    }
}

impl Prediction {
    /// The number of parameters that the input identifies.
    pub fn identified(&self) -> usize {
        self.parameters
            .iter()
            .filter(|p| p.standard_error.is_some())
            .count()
    }

    /// The largest relative standard error, %, except of parameters that are usually zero, such as
    /// an offset.
    pub fn worst_percent(&self) -> f64 {
        let judged = self.parameters.iter().filter(|p| !p.is_usually_zero);
        let percent = judged.filter_map(Predicted::percent);
        percent.filter(|p| p.is_finite()).fold(0.0, f64::max)
    }
}

impl ExperimentSetup {
    /// The setup for a model with its default parameters. Infinite values and initial states are
    /// not estimated.
    pub fn new(model: Arc<dyn Model>) -> Self {
        let parameters = model.parameters();
        let values: Vec<f64> = parameters.iter().map(|p| p.default).collect();
        let free = parameters
            .iter()
            .map(|p| p.default.is_finite() && !p.is_fixed && !p.is_initial_state)
            .collect();
        Self {
            free,
            held: vec![None; values.len()],
            values,
            noise_deg: 0.05,
            resolution_deg: ENCODER_DEG,
            step_s: CONTROL_PERIOD_S,
            duration_s: 10.0,
            model,
        }
    }

    /// The command of an input at the instants of the samples, deg.
    pub fn command(&self, excitation: &Excitation<'_>) -> Vec<f64> {
        let samples = (self.duration_s / self.step_s).floor() as u64;
        let at = |i: u64| {
            let tick = ticks(i as f64 * self.step_s);
            excitation.command(tick).to_f64()
        };
        (0..=samples).map(at).collect()
    }

    /// The predicted result of an input.
    ///
    /// # Errors
    /// [`IdentifyError`] of an input that moves nothing, or of a bench without a free parameter.
    pub fn predict(&self, command_deg: &[f64]) -> Result<Prediction, IdentifyError> {
        self.prediction(self.simulated(command_deg)?)
    }

    /// The predicted result of an experiment whose expected recording is known, as from a
    /// simulation: for a model that takes the duty of the motor, which a loop computes.
    ///
    /// # Errors
    /// [`IdentifyError`] of a recording that moves nothing, or of a bench without a free parameter.
    pub fn predict_recording(&self, expected: Recording) -> Result<Prediction, IdentifyError> {
        self.prediction(self.simulated_in(expected)?)
    }

    fn prediction(
        &self,
        (experiment, samples): (Experiment, Vec<Sample>),
    ) -> Result<Prediction, IdentifyError> {
        let recording = &experiment.recording;
        let states: Vec<ActiveLimit> = samples.iter().map(|s| s.state).collect();
        let limited = Limited::of(&recording.time_s, &states);
        let angles = recording.angle_deg.iter().map(|a| a.abs());
        let largest_angle_deg = angles.fold(0.0, f64::max);
        let mut problem = Problem::try_new(self.model.clone(), vec![experiment])?;
        let parameters = self.model.parameters();
        for (index, spec) in problem.specs.iter_mut().enumerate() {
            spec.start = self.values[index];
            // The initial state is always estimated, which increases the standard errors.
            let free = self.free[index]
                || self.held_error(index).is_some()
                || parameters[index].is_initial_state;
            spec.role = if free { Role::Free } else { Role::Fixed };
        }
        let unknowns = Unknowns::of(&problem)?.list;
        let point: Vec<f64> = unknowns.iter().map(|u| self.values[u.parameter]).collect();
        let mut information = normal_equations(&problem, &point)?.hessian;
        // A value with an error is an unknown of which one measurement exists: what it shows by
        // itself adds to the information of the experiment.
        for (row, unknown) in unknowns.iter().enumerate() {
            if let Some(error) = self.held_error(unknown.parameter) {
                information[(row, row)] += self.variance_deg2() / error.powi(2);
            }
        }
        let values = unknowns.iter().zip(&point);
        let weights: Vec<f64> = values.map(|(unknown, at)| weight(unknown, *at)).collect();
        let errors = standard_errors(&information, &weights, self.variance_deg2());
        let estimated = unknowns.iter().zip(errors);
        let estimated = estimated
            .filter(|(u, _)| self.free[u.parameter] && !parameters[u.parameter].is_initial_state);
        let predicted = |(unknown, standard_error): (&super::unknowns::Unknown, Option<f64>)| {
            let parameter = &parameters[unknown.parameter];
            Predicted {
                name: parameter.name,
                unit: parameter.unit,
                value: self.values[unknown.parameter],
                standard_error,
                is_usually_zero: parameter.default == 0.0,
            }
        };
        Ok(Prediction {
            parameters: estimated.map(predicted).collect(),
            limited,
            largest_angle_deg,
        })
    }

    /// Share of the experiment at a rate or duty limit under this command.
    pub fn limited_share(&self, command_deg: &[f64]) -> Result<f64, IdentifyError> {
        let (experiment, samples) = self.simulated(command_deg)?;
        let states: Vec<ActiveLimit> = samples.iter().map(|s| s.state).collect();
        let limited = Limited::of(&experiment.recording.time_s, &states);
        Ok(limited.rate_limited_s() / limited.duration_s)
    }

    /// The standard error of a value that is held.
    fn held_error(&self, parameter: usize) -> Option<f64> {
        self.held[parameter].filter(|error| *error > 0.0)
    }

    /// Variance of a sample: noise, and the quantisation of the encoder as uniform noise.
    fn variance_deg2(&self) -> f64 {
        self.noise_deg.powi(2) + self.resolution_deg.powi(2) / 12.0
    }

    /// The experiment as it will be recorded, without noise.
    fn simulated(&self, command_deg: &[f64]) -> Result<(Experiment, Vec<Sample>), IdentifyError> {
        let time_s: Vec<f64> = (0..command_deg.len())
            .map(|i| i as f64 * self.step_s)
            .collect();
        self.simulated_in(Recording {
            name: "experiment".into(),
            // A placeholder: the check requires an angle that varies.
            angle_deg: time_s.clone(),
            time_s,
            command_deg: command_deg.to_vec(),
            hold: Hold::Zero,
            ..Recording::default()
        })
    }

    /// The experiment with the angle of the model in place of the recorded one.
    fn simulated_in(
        &self,
        mut recording: Recording,
    ) -> Result<(Experiment, Vec<Sample>), IdentifyError> {
        let ready = |recording: Recording| {
            let name = recording.name.clone();
            let ready = Experiment::try_new(recording);
            ready.map_err(|error| IdentifyError::Recording { name, error })
        };
        let blank = ready(recording.clone())?;
        let mut samples = vec![Sample::default(); recording.time_s.len()];
        self.model
            .simulate(&blank, &self.values, &mut |i, sample| samples[i] = sample);
        recording.angle_deg = samples.iter().map(|s| s.angle_deg).collect();
        Ok((ready(recording)?, samples))
    }
}

/// The smallest step of a sampling: a tick of the simulator, s.
pub const LEAST_STEP_S: f64 = 1.0 / TICKS_PER_SECOND as f64;

/// Square roots of the diagonal of `variance * information^-1`; `None` for unknowns that are known
/// only in combination with others.
fn standard_errors(information: &DMatrix<f64>, weights: &[f64], variance: f64) -> Vec<Option<f64>> {
    let n = information.nrows();
    let acting = (0..n).filter(|i| information[(*i, *i)] > 0.0).collect();
    let Observable { rows, with } = Observable::of(information, acting, weights);
    let scale: Vec<f64> = rows.iter().map(|i| information[(*i, *i)].sqrt()).collect();
    let normalised = DMatrix::from_fn(rows.len(), rows.len(), |i, j| {
        information[(rows[i], rows[j])] / (scale[i] * scale[j])
    });
    let inverse = normalised.cholesky().map(|cholesky| cholesky.inverse());
    let error = |i: usize| {
        let row = rows.iter().position(|r| *r == i)?;
        let is_alone = with[row].is_empty();
        is_alone.then_some((variance * inverse.as_ref()?[(row, row)]).sqrt() / scale[row])
    };
    (0..n).map(error).collect()
}

/// An input of the catalogue with its designed parameters.
#[derive(Debug, Clone)]
pub struct Designed {
    /// The input.
    pub input: Input,
    /// Whether it exceeds the rate limit on purpose.
    pub is_beyond: bool,
    /// The largest command, deg.
    pub amplitude_deg: f64,
    /// The command at the samples, deg.
    pub command_deg: Vec<f64>,
    /// The expected results.
    pub prediction: Prediction,
}

#[cfg(test)]
mod tests;
