//! What can be fitted: a model that answers a recorded command.

use std::sync::Arc;

use model_core::parameter::Parameter;

use super::experiment::Experiment;
use super::recording::{Recording, RecordingError};

/// Which limit holds the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum State {
    /// None.
    #[default]
    Free,
    /// The upper limit of the rate.
    RateUp,
    /// The lower limit of the rate.
    RateDown,
    /// The limit of the duty, either way.
    Duty,
    /// A stop of the position.
    Stop,
    /// Friction: it stands.
    Stuck,
    /// The motor is off, and the model does not say what happens then.
    Off,
}

/// What a model shows at an instant of the recording.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sample {
    /// Its angle, deg.
    pub angle_deg: f64,
    /// Its rate, deg/s.
    pub rate_deg_s: f64,
    /// What limits it.
    pub state: State,
}

/// What a model is called, what its parameters are, and where a search for them begins.
pub trait Description: Send + Sync {
    /// Its name on a command line.
    fn name(&self) -> &'static str;

    /// What it is, in a sentence.
    fn summary(&self) -> &'static str;

    /// All of its parameters, those of the initial state included; their order is that of the
    /// values of every other function.
    fn parameters(&self) -> &[Parameter];

    /// Which of the parameters belong to a run and not to the actuator: the initial state.
    fn is_of_the_run(&self, parameter: usize) -> bool;

    /// Whether a parameter is held at its start value unless somebody frees it.
    fn is_fixed_by_default(&self, parameter: usize) -> bool;

    /// Within what a parameter is looked for unless somebody says otherwise.
    fn usual_bounds(&self, parameter: usize) -> (f64, f64) {
        let Parameter { min, max, .. } = self.parameters()[parameter];
        (min, max)
    }

    /// Whether a parameter is a limit, which does nothing where it is not reached.
    fn is_limit(&self, _parameter: usize) -> bool {
        false
    }

    /// Checks that a recording has the columns that the model needs beside command and angle.
    ///
    /// # Errors
    /// [`RecordingError::Missing`].
    fn accepts(&self, _recording: &Recording) -> Result<(), RecordingError> {
        Ok(())
    }

    /// Start values that a regression or a look at the data gives; all inside the ranges of the
    /// parameters.
    fn start(&self, experiments: &[Experiment]) -> Vec<f64>;

    /// Models that are this one with some of its parameters at certain values: where they fit best is
    /// a good place to begin, and this one cannot fit worse.
    fn special_cases(&self) -> Vec<Arc<dyn Model>> {
        Vec::new()
    }

    /// Whether it answers as its special cases do to the last digit, so that it has to earn what it has
    /// beyond them.
    fn contains_its_cases(&self) -> bool {
        false
    }

    /// The value of a parameter with which this model answers as a special case does with these
    /// values; `None` where any will do.
    fn lifted(&self, parameter: usize, case: &dyn Model, values: &[f64]) -> Option<f64> {
        let name = self.parameters()[parameter].name;
        let place = case.parameters().iter().position(|p| p.name == name);
        place.map(|place| values[place])
    }

    /// Whether its cost has many small dips, as friction makes them: a search looks around first, and
    /// goes down from the best places that it saw.
    fn is_rough(&self) -> bool {
        false
    }
}

/// A model of an actuator with parameters.
pub trait Model: Description {
    /// Simulates the run and hands out each sample of the recording in order. A model that leaves
    /// the numbers hands out NaN.
    fn simulate(&self, run: &Experiment, values: &[f64], seen: &mut dyn FnMut(usize, Sample));

    /// The same with the derivative of the angle by the parameters `free`, in their order.
    fn sensitivity(
        &self,
        run: &Experiment,
        values: &[f64],
        free: &[usize],
        seen: &mut dyn FnMut(usize, f64, &[f64]),
    );

    /// What a run adds to the normal equations: the residuals against `angles` and their derivatives
    /// by the parameters `free`. An angle that is NaN is not compared.
    fn sums(&self, run: &Experiment, values: &[f64], free: &[usize], angles: &[f64]) -> Sums;
}

/// Sums over the samples of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Sums {
    /// Of squared residuals.
    pub squares: f64,
    /// Of ones.
    pub samples: usize,
    /// Of residuals times derivatives of the angle.
    pub products: Vec<f64>,
    /// Of products of derivatives, by rows.
    pub information: Vec<f64>,
}

impl Sums {
    /// Nothing yet, for so many parameters.
    pub fn new(width: usize) -> Self {
        Self {
            squares: 0.0,
            samples: 0,
            products: vec![0.0; width],
            information: vec![0.0; width * width],
        }
    }

    /// Adds a sample.
    pub fn add(&mut self, residual: f64, slope: &[f64]) {
        self.squares += residual * residual;
        self.samples += 1;
        let rows = self.information.chunks_exact_mut(slope.len());
        for ((product, row), by_row) in self.products.iter_mut().zip(rows).zip(slope) {
            *product += by_row * residual;
            for (place, by_column) in row.iter_mut().zip(slope) {
                *place += by_row * by_column;
            }
        }
    }
}
