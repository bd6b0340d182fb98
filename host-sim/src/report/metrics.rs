//! The figures of merit of a model.

use model_core::{
    evaluation::{
        frequency_response::sine as fundamental,
        step_metrics::{SETTLING_BAND, Step, rate_extremes, steps},
    },
    excitation::steady_sine::SineParameters,
};
use serde::Serialize;

use super::{runs::Runs, small_signal::SmallSignal};
use crate::{
    analysis::frequency::{bandwidth_hz, falls_to_hz},
    trace::Trace,
};

/// The figures of merit of one model. A value that does not exist is `None`: the time of a level
/// that is not reached, a margin of a model without a loop.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Metrics {
    /// Of the pulse.
    pub pulse: Pulse,
    /// Of the variable step.
    pub variable_step: VariableStep,
    /// Lag of the angle behind the command at the end of the first slope of the ramp, deg.
    pub ramp_lag_deg: Option<f64>,
    /// Gain for the sine.
    pub sine_gain: Option<f64>,
    /// Phase for the sine, deg.
    pub sine_phase_deg: Option<f64>,
    /// For small signals.
    pub small_signal: SmallSignalMetrics,
}

/// The rising and the falling step of the pulse. Times count from the step of the command.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Pulse {
    /// Time from 10 % to 90 % of the rising step, s.
    pub rise_time_s: Option<f64>,
    /// Time to 90 % of the rising step, s.
    pub t90_s: Option<f64>,
    /// Overshoot of the rising step, % of it; negative if the command is not reached.
    pub overshoot_up_pct: Option<f64>,
    /// Overshoot of the falling step, % of it.
    pub overshoot_down_pct: Option<f64>,
    /// Time until the angle stays within 2 % of the rising step, s.
    pub settling_up_s: Option<f64>,
    /// Time until the angle stays within 2 % of the falling step, s.
    pub settling_down_s: Option<f64>,
    /// Largest rate upward, deg/s.
    pub max_rate_deg_s: f64,
    /// Largest rate downward, deg/s; negative.
    pub min_rate_deg_s: f64,
}

/// The thirteen steps of the variable step.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct VariableStep {
    /// Largest overshoot, deg, in the direction from the angle at the step to the command. The
    /// angle at the step need not be the previous command.
    pub worst_overshoot_deg: f64,
    /// Steps with an overshoot of more than 2 %.
    pub overshot_steps: usize,
    /// Steps that do not settle within 2 % before the next.
    pub unsettled_steps: usize,
}

/// The response to small signals.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct SmallSignalMetrics {
    /// Frequency at which the computed power is half, -3.0103 dB, Hz.
    pub half_power_hz: Option<f64>,
    /// The same frequency, measured with sines in the simulator, Hz.
    pub measured_half_power_hz: Option<f64>,
    /// Frequency at which the computed gain is -3.000 dB, Hz.
    pub minus_3_db_hz: Option<f64>,
    /// Gain margin of the loop, dB.
    pub gain_margin_db: Option<f64>,
    /// Phase margin of the loop, deg.
    pub phase_margin_deg: Option<f64>,
    /// Additional delay at which the loop becomes unstable, s.
    pub delay_margin_s: Option<f64>,
}

impl Metrics {
    /// Evaluates these runs.
    pub fn of(runs: &Runs, linear: Option<&SmallSignal>) -> Self {
        let sine = runs.trace("sine").and_then(sine);
        Self {
            pulse: runs.trace("pulse").map(pulse).unwrap_or_default(),
            variable_step: runs
                .trace("variable-step")
                .map(variable_step)
                .unwrap_or_default(),
            ramp_lag_deg: runs.trace("ramp").and_then(ramp_lag_deg),
            sine_gain: sine.map(|sine| sine.0),
            sine_phase_deg: sine.map(|sine| sine.1),
            small_signal: small_signal(runs, linear),
        }
    }
}

fn pulse(trace: &Trace) -> Pulse {
    let [t, command, angle, rate] = columns(trace);
    let mut steps = steps(t, command, angle);
    let (up, down) = (steps.next(), steps.next());
    let (min_rate_deg_s, max_rate_deg_s) = rate_extremes(rate);
    Pulse {
        rise_time_s: up.and_then(|step| step.rise_time_s),
        t90_s: up.and_then(|step| step.t90_s),
        overshoot_up_pct: up.map(|step| step.overshoot_pct),
        overshoot_down_pct: down.map(|step| step.overshoot_pct),
        settling_up_s: up.and_then(|step| step.settling_time_s),
        settling_down_s: down.and_then(|step| step.settling_time_s),
        max_rate_deg_s,
        min_rate_deg_s,
    }
}

fn variable_step(trace: &Trace) -> VariableStep {
    let [t, command, angle, _] = columns(trace);
    let steps: Vec<Step> = steps(t, command, angle).collect();
    let starts = steps
        .iter()
        .map(|step| t.partition_point(|at| *at < step.time_s));
    let ends = starts.clone().skip(1).chain([angle.len()]);
    let spans = steps.iter().zip(starts.zip(ends));
    let overshoots: Vec<f64> = spans
        .map(|(step, (start, end))| overshoot_deg(step, &angle[start..end]))
        .collect();
    let shares = steps.iter().zip(&overshoots);
    let is_overshot =
        |(step, deg): &(&Step, &f64)| **deg > SETTLING_BAND * (step.to_deg - step.from_deg).abs();
    VariableStep {
        worst_overshoot_deg: overshoots.iter().copied().fold(0.0, f64::max),
        overshot_steps: shares.filter(is_overshot).count(),
        unsettled_steps: steps
            .iter()
            .filter(|step| step.settling_time_s.is_none())
            .count(),
    }
}

/// The overshoot of these angles of a step, in the direction from the first of them.
fn overshoot_deg(step: &Step, angle: &[f64]) -> f64 {
    let to = step.to_deg;
    let upward = angle.first().is_some_and(|first| *first < to);
    let beyond = angle
        .iter()
        .map(|angle| if upward { angle - to } else { to - angle });
    beyond.fold(0.0, f64::max)
}

/// The mean lag over the last quarter of a second before the command first reaches its top.
fn ramp_lag_deg(trace: &Trace) -> Option<f64> {
    const WINDOW_S: f64 = 0.25;
    let [t, command, angle, _] = columns(trace);
    let top = command.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let end = command.iter().position(|c| *c == top)?;
    let start = t.partition_point(|at| *at < t[end] - WINDOW_S);
    let lags: Vec<f64> = (start..end).map(|i| command[i] - angle[i]).collect();
    (!lags.is_empty()).then(|| lags.iter().sum::<f64>() / lags.len() as f64)
}

/// Gain and phase, deg, over all periods but the first.
fn sine(trace: &Trace) -> Option<(f64, f64)> {
    let frequency_hz = SineParameters::default().frequency_hz;
    let [t, command, angle, _] = columns(trace);
    let period = t.iter().position(|t| *t >= 1.0 / frequency_hz)?;
    let periods = t.len() / period - 1;
    let rows = period..period * (periods + 1);
    let of = |column: &[f64]| fundamental(&column[rows.clone()], periods as u32);
    let (angle, command) = (of(angle), of(command));
    let phase_deg = angle.1 - command.1;
    let phase_deg = phase_deg - 360.0 * (phase_deg / 360.0).round();
    Some((angle.0 / command.0, phase_deg))
}

fn small_signal(runs: &Runs, linear: Option<&SmallSignal>) -> SmallSignalMetrics {
    let closed = linear.map(|linear| &linear.closed);
    let margins = linear.and_then(|linear| linear.margins);
    SmallSignalMetrics {
        half_power_hz: closed.and_then(bandwidth_hz),
        measured_half_power_hz: runs.bandwidth_hz,
        minus_3_db_hz: closed.and_then(|closed| falls_to_hz(closed, -3.0)),
        gain_margin_db: margins.and_then(|m| m.gain_db).map(|m| m.value),
        phase_margin_deg: margins.and_then(|m| m.phase_deg).map(|m| m.value),
        delay_margin_s: margins.and_then(|m| m.delay_s),
    }
}

/// Time, command, angle and rate.
fn columns(trace: &Trace) -> [&[f64]; 4] {
    ["time_s", "command_deg", "angle_deg", "rate_deg_s"]
        .map(|name| trace.column(name).unwrap_or_default())
}
