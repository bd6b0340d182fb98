//! The interface between a model and the search.

mod parameters;

use std::ops::Range;
use std::sync::Arc;

pub(crate) use parameters::parameters;
pub use parameters::{ModelParameter, ParameterValues};

use super::experiment::Experiment;
use super::loss::weighed;
use super::recording::{Recording, RecordingError};

/// The limit that is active in a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ActiveLimit {
    /// None.
    #[default]
    Free,
    /// The upper rate limit.
    RateUp,
    /// The lower rate limit.
    RateDown,
    /// The duty limit, in either direction.
    Duty,
    /// A hard stop.
    Stop,
    /// Static friction: the shaft does not move.
    Stuck,
    /// The motor is off, and the model does not describe that.
    Off,
}

/// The output of a model at a sample of the recording.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sample {
    /// Angle, deg.
    pub angle_deg: f64,
    /// Rate, deg/s.
    pub rate_deg_s: f64,
    /// The active limit.
    pub state: ActiveLimit,
}

/// Where a nested model fits best: its parameters by name.
pub struct NestedOptimum<'a> {
    /// The nested model.
    pub model: &'a dyn Model,
    /// Its values, in the order of its parameters.
    pub values: &'a [f64],
}

impl NestedOptimum<'_> {
    /// The value of a parameter; `None` where the nested model has no such parameter.
    pub fn value(&self, name: &str) -> Option<f64> {
        let index = self.model.parameter_index(name)?;
        Some(self.values[index])
    }
}

/// Name, parameters and relations of a model.
pub trait Description: Send + Sync {
    /// Its name on the command line.
    fn name(&self) -> &'static str;

    /// A one-sentence summary.
    fn summary(&self) -> &'static str;

    /// All parameters, including the initial state, in the order in which all functions take their
    /// values.
    fn parameters(&self) -> &[ModelParameter];

    /// The index of the parameter of this name.
    fn parameter_index(&self, name: &str) -> Option<usize> {
        self.parameters().iter().position(|p| p.name == name)
    }

    /// Whether the parameter of this name exists and is fixed unless the user frees it.
    fn is_fixed_by_default(&self, name: &str) -> bool {
        self.parameter_index(name)
            .is_some_and(|index| self.parameters()[index].is_fixed)
    }

    /// Checks that a recording has the columns that the model needs besides command and angle.
    ///
    /// # Errors
    /// [`RecordingError::Missing`].
    fn accepts(&self, _recording: &Recording) -> Result<(), RecordingError> {
        Ok(())
    }

    /// The parameter that the recording must have as a column or a constant, and has not, unless a
    /// request sets it: no default value is that of any actuator.
    fn unmeasured(&self, _recording: &Recording) -> Option<&'static str> {
        None
    }

    /// Nested models: this model with some of its parameters at particular values. Their optima are
    /// starting values, so that this model never fits worse.
    fn nested_models(&self) -> Vec<Arc<dyn Model>> {
        Vec::new()
    }

    /// Whether it reproduces its nested models exactly. Its additional parameters are then kept
    /// only where a likelihood-ratio test requires them.
    fn contains_nested_models_exactly(&self) -> bool {
        false
    }

    /// The value of a parameter with which this model reproduces the optimum of a nested model;
    /// `None` where any value will do.
    fn value_from_nested(&self, name: &str, nested: &NestedOptimum<'_>) -> Option<f64> {
        nested.value(name)
    }

    /// Whether it describes a shaft that friction holds, which looks like a clipped sensor.
    fn has_friction(&self) -> bool {
        false
    }

    /// Whether its cost has many local minima, as friction causes them. The search then evaluates
    /// many points and descends from the best ones.
    fn has_many_minima(&self) -> bool {
        false
    }
}

/// Number of derivatives by the command in one call of [`Model::command_sensitivity`].
pub const COMMANDS_PER_PASS: usize = 8;

/// A model of an actuator, as the search uses it.
pub trait Model: Description {
    /// Starting values from a regression over the recordings, in the order of the parameters.
    fn starting_values(&self, experiments: &[Experiment]) -> Vec<f64>;

    /// Simulates the run and passes each sample of the recording to `output`, in order. A model
    /// that diverges passes NaN.
    fn simulate(&self, run: &Experiment, values: &[f64], output: &mut dyn FnMut(usize, Sample));

    /// The same with the sensitivities: the derivatives of the angle by the parameters `free`, in
    /// their order.
    fn sensitivity(
        &self,
        run: &Experiment,
        values: &[f64],
        free: &[usize],
        output: &mut dyn FnMut(usize, f64, &[f64]),
    );

    /// The same by the levels of segments of the command, each constant and at most
    /// [`COMMANDS_PER_PASS`] of them.
    fn command_sensitivity(
        &self,
        run: &Experiment,
        values: &[f64],
        segments: Range<usize>,
        output: &mut dyn FnMut(usize, f64, &[f64]),
    );

    /// The contribution of a run to the normal equations: the residuals against `angles` and their
    /// derivatives by the parameters `free`. An angle that is NaN is not compared.
    fn sums(&self, run: &Experiment, values: &[f64], free: &[usize], angles: &[f64]) -> Sums;
}

/// Sums over the samples of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Sums {
    /// Of twice the losses of the residuals: of their squares with
    /// [`Loss::Squares`](super::loss::Loss::Squares).
    pub squares: f64,
    /// Number of samples.
    pub samples: usize,
    /// Of residuals times derivatives of the angle.
    pub products: Vec<f64>,
    /// Of products of derivatives, by rows.
    pub information: Vec<f64>,
}

impl Sums {
    /// Zero, for this number of parameters.
    pub fn new(width: usize) -> Self {
        Self {
            squares: 0.0,
            samples: 0,
            products: vec![0.0; width],
            information: vec![0.0; width * width],
        }
    }

    /// Adds a sample under a loss of this curvature.
    pub fn add(&mut self, curvature: f64, residual: f64, slope: &[f64]) {
        let (square, weight) = weighed(curvature, residual);
        self.squares += square;
        self.samples += 1;
        let rows = self.information.chunks_exact_mut(slope.len());
        for ((product, row), by_row) in self.products.iter_mut().zip(rows).zip(slope) {
            let weighted = weight * by_row;
            *product += weighted * residual;
            for (place, by_column) in row.iter_mut().zip(slope) {
                *place += weighted * by_column;
            }
        }
    }
}
