//! Systems with random parameters, and recordings of them.

use model_core::actuator::ModelKind;
use model_core::named::Named;
use model_core::sensors::noise::Noise;

use super::fault::uniform;
use crate::command::{Reader, Segment};
use crate::experiment::Experiment;
use crate::model::ModelParameter;
use crate::models;
use crate::recording::{Hold, Recording};
use crate::synthetic::simulated;

/// A system: the model, and its true parameters.
pub struct System {
    /// The model.
    pub kind: ModelKind,
    /// The true parameters.
    pub truth: Vec<(&'static str, f64)>,
}

impl System {
    /// Random parameters.
    pub fn of(noise: &mut Noise, is_second_order: bool) -> Self {
        let mut truth = vec![
            ("delay_s", uniform(noise, 0.005, 0.04)),
            ("rate_limit_up_deg_s", uniform(noise, 120.0, 400.0)),
            ("rate_limit_down_deg_s", uniform(noise, 120.0, 400.0)),
            ("gain", uniform(noise, 0.9, 1.1)),
            ("offset_deg", uniform(noise, -2.0, 2.0)),
        ];
        let kind = if is_second_order {
            let (w, damping) = (uniform(noise, 15.0, 45.0), uniform(noise, 0.6, 1.2));
            truth.push(("position_gain_per_s2", w * w));
            truth.push(("rate_gain_per_s", 2.0 * damping * w));
            ModelKind::BlackBox2
        } else {
            truth.push(("pole_rad_s", uniform(noise, 10.0, 50.0)));
            ModelKind::BlackBox1
        };
        Self { kind, truth }
    }

    /// Its response to a standard input at 250 Hz; with a held command as of a digital link.
    pub fn response(&self, input: &str, is_held: bool, every: u64) -> Option<Recording> {
        let mut recording = simulated(self.kind, input, every, &self.truth).ok()?;
        if is_held {
            recording.hold = Hold::Zero;
            let run = Experiment::try_new(recording.clone()).ok()?;
            recording.angle_deg = self.angles(&run)?;
            recording.hold = Hold::Auto;
        }
        Some(recording)
    }

    /// Its response to random steps of different size, at any instant: at 50 Hz, or at 250 Hz with
    /// a command that is limited to a share of its range, which the recording does not show.
    pub fn stepped(&self, noise: &mut Noise, limit: Option<f64>) -> Option<Recording> {
        let step_s = if limit.is_some() { 0.004 } else { 0.02 };
        let time_s: Vec<f64> = (0..(8.0 / step_s) as u32)
            .map(|i| step_s * f64::from(i))
            .collect();
        let (mut at_s, mut levels) = (0.0, vec![(0.0, 0.0)]);
        while at_s < 7.0 {
            let size = uniform(noise, 20.0, 60.0);
            let before: f64 = levels[levels.len() - 1].1;
            at_s += uniform(noise, 0.8, 2.0);
            levels.push((
                at_s,
                if before > 0.0 {
                    before - size
                } else {
                    before + size
                },
            ));
        }
        let greatest = levels
            .iter()
            .fold(0.0_f64, |most, (_, level)| most.max(level.abs()));
        let limit_deg = limit.unwrap_or(1.0) * greatest;
        // A limited drive is not asynchronous as well.
        let grid_s = limit.map_or(1e-9, |_| step_s);
        let steps = |limit_deg: f64| -> Vec<Segment> {
            let steps = levels.iter().map(|(at_s, level)| {
                let at_s = (at_s / grid_s).round() * grid_s;
                Segment::constant(
                    (at_s * 1e9).round() as i64,
                    level.clamp(-limit_deg, limit_deg),
                )
            });
            steps.collect()
        };
        let sent = steps(f64::INFINITY);
        let mut reader = Reader::new(&sent);
        let at = |t: &f64| reader.at((t * 1e9).round() as i64);
        let mut recording = Recording {
            name: "steps".into(),
            command_deg: time_s.iter().map(at).collect(),
            // A placeholder: the check requires an angle that varies.
            angle_deg: time_s.clone(),
            time_s,
            ..Recording::default()
        };
        let mut run = Experiment::try_new(recording.clone()).ok()?;
        run.command = steps(limit_deg);
        recording.angle_deg = self.angles(&run)?;
        Some(recording)
    }

    fn angles(&self, run: &Experiment) -> Option<Vec<f64>> {
        response(self.kind.name(), &self.truth, run)
    }
}

/// The angles of a model with these parameters, those that the recording states, and the defaults
/// of the others.
pub fn response(model: &str, truth: &[(&str, f64)], run: &Experiment) -> Option<Vec<f64>> {
    let model = models::named(model)?;
    let value = |p: &ModelParameter| {
        let known = truth.iter().find(|(name, _)| *name == p.name);
        let known = known.map(|(_, value)| value);
        *known
            .or(run.recording.constants.get(p.name))
            .unwrap_or(&p.default)
    };
    let values: Vec<f64> = model.parameters().iter().map(value).collect();
    let mut angles = vec![0.0; run.len()];
    model.simulate(run, &values, &mut |i, sample| angles[i] = sample.angle_deg);
    Some(angles)
}

/// The instants of the fine samples that a faulty clock takes.
pub fn resampled(fine: &Recording, at_s: impl Fn(f64) -> f64) -> Recording {
    let step_s = fine.time_s[1] - fine.time_s[0];
    let take = |i: usize, column: &[f64]| {
        let place = (at_s(fine.time_s[i]) / step_s).round().max(0.0) as usize;
        column[place.min(column.len() - 1)]
    };
    let places = (0..fine.len()).step_by(FINER as usize);
    Recording {
        time_s: places.clone().map(|i| fine.time_s[i]).collect(),
        command_deg: places.clone().map(|i| fine.command_deg[i]).collect(),
        angle_deg: places.map(|i| take(i, &fine.angle_deg)).collect(),
        ..fine.clone()
    }
}

/// Fine samples per sample where the clock is faulty: 0.1 ms.
pub const FINER: u64 = 40;
