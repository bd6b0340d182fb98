//! Quantities of traces for the paper's qualitative statements.

use crate::{
    Failure,
    host::{sample_at, seconds},
    models,
    runs::Run,
    study::Study,
};

/// The mean of several traces, sample by sample.
pub fn mean(traces: &[Vec<f64>]) -> Vec<f64> {
    let length = traces.iter().map(Vec::len).min().unwrap_or(0);
    let at = |i: usize| traces.iter().map(|t| t[i]).sum::<f64>() / traces.len() as f64;
    (0..length).map(at).collect()
}

/// The greatest standard deviation of several traces around their mean.
pub fn max_standard_deviation_deg(traces: &[Vec<f64>]) -> f64 {
    let centre = mean(traces);
    let count = (traces.len().max(2) - 1) as f64;
    let at = |(i, m): (usize, &f64)| {
        let squares = traces.iter().map(|t| (t[i] - m).powi(2));
        (squares.sum::<f64>() / count).sqrt()
    };
    centre.iter().enumerate().map(at).fold(0.0, f64::max)
}

/// The command's steps: each the range of its samples, with the sign of the step.
pub fn steps(command_deg: &[f64]) -> Vec<(std::ops::Range<usize>, f64)> {
    let mut steps = Vec::new();
    let mut start = 0;
    let mut before = f64::NAN;
    for level in command_deg.chunk_by(|a, b| a == b) {
        let range = start..start + level.len();
        start = range.end;
        if !before.is_nan() {
            steps.push((range, (level[0] - before).signum()));
        }
        before = level[0];
    }
    steps
}

/// How far one trace is ahead of another in the direction of each step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Ahead {
    /// Number of steps in which it is ahead by more than [`VISIBLE_DEG`].
    pub steps: usize,
    /// Number of steps.
    pub of: usize,
    /// Largest lead, deg.
    pub largest_deg: f64,
}

/// Smallest difference that is visible in a figure of 180 deg, deg.
pub const VISIBLE_DEG: f64 = 2.0;

/// How far `model` is ahead of `data`.
pub fn ahead(command_deg: &[f64], data: &[f64], model: &[f64]) -> Ahead {
    let mut found = Ahead::default();
    for (range, sign) in steps(command_deg) {
        let differences = range.map(|i| sign * (model[i] - data[i]));
        let largest = differences.fold(0.0, f64::max);
        found.of += 1;
        found.steps += usize::from(largest > VISIBLE_DEG);
        found.largest_deg = found.largest_deg.max(largest);
    }
    found
}

/// Largest overshoot of a trace beyond the commands of its steps, deg.
pub fn overshoot_deg(command_deg: &[f64], trace: &[f64]) -> f64 {
    let mut most = 0.0_f64;
    for (range, sign) in steps(command_deg) {
        let level = command_deg[range.start];
        // A trace that starts a step beyond its level counts only after it has returned to the
        // level.
        let mut has_arrived = false;
        for i in range {
            let beyond = sign * (trace[i] - level);
            has_arrived |= beyond <= 0.0;
            if has_arrived {
                most = most.max(beyond);
            }
        }
    }
    most
}

/// Root mean square of a difference between two instants, s, at 250 Hz.
pub fn rms_deg(a: &[f64], b: &[f64], from_s: f64, to_s: f64) -> f64 {
    let (from, to) = (sample_at(from_s), sample_at(to_s));
    let pairs = a.iter().zip(b).take(to).skip(from);
    let (sum, count) = pairs.fold((0.0, 0), |(sum, count), (a, b)| {
        (sum + (a - b).powi(2), count + 1)
    });
    (sum / f64::from(count.max(1))).sqrt()
}

/// Time, s at 250 Hz, and value, deg, of the largest difference of two traces between two instants.
pub fn largest_difference(a: &[f64], b: &[f64], from_s: f64, to_s: f64) -> (f64, f64) {
    let (from, to) = (sample_at(from_s), sample_at(to_s));
    let differences = a.iter().zip(b).map(|(a, b)| (a - b).abs()).enumerate();
    let within = differences.take(to).skip(from);
    let largest_difference = within.max_by(|a, b| a.1.total_cmp(&b.1));
    largest_difference.map_or((f64::NAN, f64::NAN), |(i, deg)| (seconds(i), deg))
}

/// The traces of an input in one condition, at 250 Hz.
pub struct Traces {
    /// The command.
    pub command_deg: Vec<f64>,
    /// The runs.
    pub runs_deg: Vec<Vec<f64>>,
    /// Their mean.
    pub mean_deg: Vec<f64>,
    /// Mean of their duties, %.
    pub duty_pct: Vec<f64>,
    /// Each model with the paper's numbers.
    pub printed_deg: Vec<Vec<f64>>,
    /// Each fitted model: the mean of its responses.
    pub fitted_deg: Vec<Vec<f64>>,
}

impl Traces {
    /// The traces of an input in a condition; `None` without runs.
    ///
    /// # Errors
    /// Those of [`models::printed`].
    pub fn of(study: &Study, condition: usize, input: &str) -> Result<Option<Self>, Failure> {
        use crate::runs::SampleRate::Hz250;
        let runs: Vec<&Run> = study.runs(condition, input);
        let Some(first) = runs.first() else {
            return Ok(None);
        };
        let recordings: Vec<_> = runs.iter().map(|run| run.recording(Hz250)).collect();
        let column = |of: &dyn Fn(&identification::Recording) -> Vec<f64>| {
            recordings.iter().map(of).collect::<Vec<_>>()
        };
        let runs_deg = column(&|r| r.angle_deg.clone());
        let duties = column(&|r| r.duty_pct.clone().unwrap_or_default());
        let printed = (0..models::MODELS.len()).map(|model| models::printed(model, first));
        let fitted = (0..models::MODELS.len()).map(|model| {
            let fit = study.fit(condition, Hz250, input, model);
            let responses = fit.map(|fitted| {
                let experiments = fitted.fit.experiments.iter();
                experiments
                    .map(|e| e.predicted_deg.clone())
                    .collect::<Vec<_>>()
            });
            mean(&responses.unwrap_or_default())
        });
        Ok(Some(Self {
            command_deg: recordings[0].command_deg.clone(),
            mean_deg: mean(&runs_deg),
            duty_pct: mean(&duties),
            runs_deg,
            printed_deg: printed.collect::<Result<_, _>>()?,
            fitted_deg: fitted.collect(),
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ahead_counts_each_step_by_its_own_sign() {
        let command = [0.0, 10.0, 10.0, -10.0, -10.0];
        let data = [0.0, 0.0, 5.0, 5.0, 0.0];
        let model = [0.0, 3.0, 8.0, 4.0, -1.0];
        let found = ahead(&command, &data, &model);
        assert_eq!((found.steps, found.of, found.largest_deg), (1, 2, 3.0));
    }

    #[test]
    fn overshoot_counts_only_after_the_level_was_reached() {
        let command = [0.0, 10.0, 10.0, 10.0, 0.0, 0.0];
        let trace = [0.0, 5.0, 11.0, 10.0, 9.0, -3.0];
        assert_eq!(overshoot_deg(&command, &trace), 3.0);
        assert_eq!(overshoot_deg(&[0.0, 1.0, 0.0], &[0.0, 0.0, 5.0]), 0.0);
    }

    #[test]
    fn the_largest_standard_deviation_is_given() {
        let spread = max_standard_deviation_deg(&[vec![0.0, 1.0], vec![0.0, 3.0]]);
        assert!((spread - 2.0_f64.sqrt()).abs() < 1e-12);
    }
}
