//! A recording prepared for simulation.

use std::sync::Arc;

use super::command::{Reader, Segment, segments};
use super::loss::Loss;
use super::recording::{Hold, Recording, RecordingError};

/// Assumptions where a recording leaves its command open.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Assumptions {
    /// Zero-order hold: a command that changes from sample to sample keeps each value until the
    /// next.
    pub is_held: bool,
    /// The actuator is at rest until the first command arrives; otherwise the first command was
    /// applied long before.
    pub begins_at_rest: bool,
}

/// A recording that was checked, and its command as a function of time.
#[derive(Debug, Clone)]
pub struct Experiment {
    /// The recording.
    pub recording: Arc<Recording>,
    /// Instants of the samples after the first, ns. All steps of even samples are identical, so
    /// that cached transitions apply to all.
    pub time_ns: Vec<i64>,
    /// The command.
    pub command: Vec<Segment>,
    /// The logged voltage at the motor as a share of the mean supply, held from sample to sample;
    /// empty where no duty was logged.
    pub drive: Vec<Segment>,
    /// The mean supply, V, where it was logged.
    pub supply_v: Option<f64>,
    /// Whether there are only a few different step lengths.
    pub is_even: bool,
    /// Whether the actuator is at rest until the first command arrives.
    pub begins_at_rest: bool,
    /// Whether it is used for starting values only: models that are integrated take longer steps.
    pub is_preview: bool,
    /// How its residuals count.
    pub loss: Loss,
}

/// Number of consecutive samples that are selected together.
const BLOCK: usize = 250;

/// Multiples of the golden ratio fill the circle most evenly (Steinhaus' three gaps).
const GOLDEN: f64 = 0.618_033_988_749_895;

/// Number of step lengths whose transitions are cached.
const FEW_STEPS: usize = 4;

impl Experiment {
    /// Prepares a recording.
    ///
    /// # Errors
    /// Those of [`Recording::check`].
    pub fn try_new(recording: Recording) -> Result<Self, RecordingError> {
        recording.check()?;
        let first_s = recording.time_s[0];
        let instant = |time_s: &f64| ((time_s - first_s) * 1e9).round() as i64;
        let mut time_ns: Vec<i64> = recording.time_s.iter().map(instant).collect();
        // Instants remain distinct when they are less than a nanosecond apart.
        for i in 1..time_ns.len() {
            time_ns[i] = time_ns[i].max(time_ns[i - 1] + 1);
        }
        let supply_v = recording.supply_v.as_deref().and_then(mean);
        Ok(Self {
            drive: drive(&recording, &time_ns, supply_v),
            supply_v,
            command: segments(&time_ns, &recording.command_deg, recording.hold),
            is_even: is_even(&time_ns),
            begins_at_rest: false,
            is_preview: false,
            loss: Loss::Squares,
            recording: Arc::new(recording),
            time_ns,
        })
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.time_ns.len()
    }

    /// Whether there is no sample; always false for a checked recording.
    pub fn is_empty(&self) -> bool {
        self.time_ns.is_empty()
    }

    /// The command, to be evaluated at increasing instants.
    pub fn commands(&self) -> Reader<'_> {
        Reader::new(&self.command)
    }

    /// The same with a held command that has a segment from each of these samples on, in increasing
    /// order and from the first on, also where its level remains: derivatives by the command are
    /// those by its segments.
    pub fn with_segments_at(&self, starts: &[usize]) -> Self {
        let mut commands = self.commands();
        let instants = starts.iter().filter_map(|start| self.time_ns.get(*start));
        let held = instants.map(|time_ns| Segment::constant(*time_ns, commands.at(*time_ns)));
        Self {
            command: held.collect(),
            ..self.clone()
        }
    }

    /// The same under other assumptions. A hold that the recording specifies takes precedence.
    pub fn under(&self, assumptions: Assumptions) -> Self {
        let hold = match self.recording.hold {
            Hold::Auto if assumptions.is_held => Hold::Zero,
            specified => specified,
        };
        Self {
            command: segments(&self.time_ns, &self.recording.command_deg, hold),
            begins_at_rest: assumptions.begins_at_rest,
            ..self.clone()
        }
    }

    /// The same with the instants of its samples, but not of its command, scaled by `1 + share`.
    pub fn on_clock(&self, share: f64) -> Self {
        let scaled = |t: &i64| (*t as f64 * (1.0 + share)).round() as i64;
        let time_ns: Vec<i64> = self.time_ns.iter().map(scaled).collect();
        Self {
            is_even: is_even(&time_ns),
            time_ns,
            ..self.clone()
        }
    }

    /// The same with one of `every` blocks of samples compared and the complete command. The
    /// samples within a block resolve fast motion, and the irregular blocks alias with no period of
    /// the recording.
    pub fn thinned(&self, every: usize) -> Self {
        let share = 1.0 / every.max(1) as f64;
        self.with_samples(|i| ((i / BLOCK) as f64 * GOLDEN).fract() < share)
    }

    /// The same with only some samples compared and the complete command.
    pub fn with_samples(&self, selected: impl Fn(&usize) -> bool) -> Self {
        let places: Vec<usize> = (0..self.len()).filter(selected).collect();
        let take = |column: &[f64]| places.iter().map(|i| column[*i]).collect::<Vec<f64>>();
        let some = |column: &Option<Vec<f64>>| column.as_deref().map(take);
        let full = &self.recording;
        let time_ns: Vec<i64> = places.iter().map(|i| self.time_ns[*i]).collect();
        Self {
            recording: Arc::new(Recording {
                name: full.name.clone(),
                time_s: take(&full.time_s),
                command_deg: take(&full.command_deg),
                angle_deg: take(&full.angle_deg),
                rate_deg_s: some(&full.rate_deg_s),
                duty_pct: some(&full.duty_pct),
                current_ma: some(&full.current_ma),
                supply_v: some(&full.supply_v),
                motor_on: some(&full.motor_on),
                hold: full.hold,
                constants: full.constants.clone(),
            }),
            is_even: is_even(&time_ns),
            time_ns,
            command: self.command.clone(),
            drive: self.drive.clone(),
            supply_v: self.supply_v,
            begins_at_rest: self.begins_at_rest,
            is_preview: self.is_preview,
            loss: self.loss,
        }
    }

    /// From the first to the last sample, s.
    pub fn duration_s(&self) -> f64 {
        *self.time_ns.last().unwrap_or(&0) as f64 * 1e-9
    }
}

/// The logged duty, corrected for variations of the supply.
fn drive(recording: &Recording, time_ns: &[i64], mean_v: Option<f64>) -> Vec<Segment> {
    let Some(duty_pct) = &recording.duty_pct else {
        return Vec::new();
    };
    let supply = |i: usize| recording.supply_v.as_ref().map(|v| v[i]);
    let share = |(i, duty_pct): (usize, &f64)| match (supply(i), mean_v) {
        (Some(supply_v), Some(mean_v)) if !supply_v.is_nan() => {
            duty_pct / 100.0 * supply_v / mean_v
        }
        _ => duty_pct / 100.0,
    };
    let shares: Vec<f64> = duty_pct.iter().enumerate().map(share).collect();
    segments(time_ns, &shares, Hold::Zero)
}

/// The mean of the values that are not NaN, if it is positive.
fn mean(values: &[f64]) -> Option<f64> {
    let numbers = || values.iter().filter(|v| !v.is_nan());
    let mean = numbers().sum::<f64>() / numbers().count() as f64;
    (mean > 0.0).then_some(mean)
}

/// Whether nine of ten steps have one of a few lengths.
fn is_even(time_ns: &[i64]) -> bool {
    let mut lengths: Vec<i64> = Vec::new();
    let mut others = 0;
    for step in time_ns.windows(2).map(|t| t[1] - t[0]) {
        if !lengths.contains(&step) {
            if lengths.len() < FEW_STEPS {
                lengths.push(step);
            } else {
                others += 1;
            }
        }
    }
    others * 10 <= time_ns.len()
}
