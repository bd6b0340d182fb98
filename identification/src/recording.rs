//! A measurement: the command and the measured angle, at instants of any spacing.

use std::collections::BTreeMap;

use model_core::parameter::Shown;

/// The hold assumption: the command between two of its samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Hold {
    /// Decided from the data: a step where the command is constant before and after, smooth where
    /// it changes from sample to sample.
    #[default]
    Auto,
    /// Zero-order hold: it keeps its value until the next sample, as on a digital link.
    Zero,
    /// A smooth curve through the samples, as sampled from a faster source.
    Smooth,
}

/// The recording of one run.
///
/// All columns are as long as `time_s`. A value that is NaN is missing: an angle is then not
/// compared, a command keeps its last value.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Recording {
    /// Its name, usually that of its file.
    pub name: String,
    /// Instants of the samples, s: finite and increasing, of any spacing.
    pub time_s: Vec<f64>,
    /// Commanded angle, deg.
    pub command_deg: Vec<f64>,
    /// Measured angle, deg.
    pub angle_deg: Vec<f64>,
    /// Measured rate, deg/s.
    pub rate_deg_s: Option<Vec<f64>>,
    /// Duty at the motor, %.
    pub duty_pct: Option<Vec<f64>>,
    /// Current of the motor, mA.
    pub current_ma: Option<Vec<f64>>,
    /// Supply voltage, V.
    pub supply_v: Option<Vec<f64>>,
    /// Whether the motor was on; 0 is off. Always on without this column.
    pub motor_on: Option<Vec<f64>>,
    /// The hold assumption.
    pub hold: Hold,
    /// Known values of this run by the name of a parameter, such as `pendulum_mass_kg`.
    pub constants: BTreeMap<String, f64>,
}

/// Why a recording cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RecordingError {
    /// A column is longer or shorter than the time.
    #[error("{column} has {found} samples, expected {expected} as of time_s")]
    Length {
        /// The column.
        column: &'static str,
        /// Its length.
        found: usize,
        /// The length of the time.
        expected: usize,
    },
    /// There are too few samples.
    #[error("{found} samples with an angle, expected at least {expected}")]
    Short {
        /// Samples with an angle.
        found: usize,
        /// Required samples.
        expected: usize,
    },
    /// The time does not increase, or is not a number.
    #[error(
        "time_s is {} in sample {index} after {}, expected an increasing time",
        Shown(*value),
        Shown(*before)
    )]
    Time {
        /// The sample, counted from 1.
        index: usize,
        /// Its time, s.
        value: f64,
        /// The time before it, s.
        before: f64,
    },
    /// A value is infinite or implausibly large.
    #[error(
        "{column} is {} in sample {index}, expected a number from -{LARGEST} to {LARGEST}, \
         or NaN where it is missing",
        Shown(*value)
    )]
    Value {
        /// The column.
        column: &'static str,
        /// The sample, counted from 1.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// The command has no value.
    #[error("command_deg has no number, expected at least one")]
    NoCommand,
    /// The motor is never on.
    #[error("motor_on is 0 in all samples: nothing can be identified from a motor that is off")]
    Off,
    /// A signal is constant.
    #[error("{0} is the same in all samples: nothing can be identified from a recording at rest")]
    Constant(&'static str),
    /// A column that the model needs is missing.
    #[error("no column {0}, which the model needs")]
    Missing(&'static str),
}

/// Largest plausible angle, duty or voltage of a servo.
const LARGEST: f64 = 1e9;

/// The fewest samples from which a model can be fitted.
pub const FEWEST_SAMPLES: usize = 8;

impl Recording {
    /// The columns except the time, each with its name.
    fn columns(&self) -> impl Iterator<Item = (&'static str, &[f64])> {
        let optional = [
            ("rate_deg_s", &self.rate_deg_s),
            ("duty_pct", &self.duty_pct),
            ("current_ma", &self.current_ma),
            ("supply_v", &self.supply_v),
            ("motor_on", &self.motor_on),
        ];
        let optional = optional
            .into_iter()
            .filter_map(|(name, column)| Some((name, column.as_deref()?)));
        [
            ("command_deg", self.command_deg.as_slice()),
            ("angle_deg", self.angle_deg.as_slice()),
        ]
        .into_iter()
        .chain(optional)
    }

    /// Checks that a model can be fitted to it.
    ///
    /// ```
    /// use identification::{Recording, RecordingError};
    ///
    /// let nothing = Recording::default();
    /// assert!(matches!(nothing.check(), Err(RecordingError::Short { found: 0, .. })));
    /// ```
    ///
    /// # Errors
    /// The first problem.
    pub fn check(&self) -> Result<(), RecordingError> {
        let expected = self.time_s.len();
        for (column, values) in self.columns() {
            let found = values.len();
            if found != expected {
                return Err(RecordingError::Length {
                    column,
                    found,
                    expected,
                });
            }
            let wrong = |value: &f64| value.abs() > LARGEST;
            if let Some(index) = values.iter().position(wrong) {
                return Err(RecordingError::Value {
                    column,
                    index: index + 1,
                    value: values[index],
                });
            }
        }
        self.check_time()?;
        self.check_content()
    }

    fn check_time(&self) -> Result<(), RecordingError> {
        let mut before = f64::NEG_INFINITY;
        for (index, &value) in self.time_s.iter().enumerate() {
            // False for NaN.
            if !(value > before && value.abs() <= LARGEST) {
                return Err(RecordingError::Time {
                    index: index + 1,
                    value,
                    before,
                });
            }
            before = value;
        }
        Ok(())
    }

    fn check_content(&self) -> Result<(), RecordingError> {
        let found = self.angle_deg.iter().filter(|a| !a.is_nan()).count();
        if found < FEWEST_SAMPLES {
            return Err(RecordingError::Short {
                found,
                expected: FEWEST_SAMPLES,
            });
        }
        if self.command_deg.iter().all(|c| c.is_nan()) {
            return Err(RecordingError::NoCommand);
        }
        let is_on = |on: &Vec<f64>| on.iter().any(|on| *on != 0.0);
        if !self.motor_on.as_ref().is_none_or(is_on) {
            return Err(RecordingError::Off);
        }
        if is_constant(&self.angle_deg) {
            return Err(RecordingError::Constant("angle_deg"));
        }
        Ok(())
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }
}

/// Whether all numbers are the same.
pub(super) fn is_constant(values: &[f64]) -> bool {
    let mut numbers = values.iter().filter(|v| !v.is_nan());
    let first = numbers.next();
    numbers.all(|value| Some(value) == first)
}
