//! Figures of merit of a run: those of its first step, the largest rates and the tracking error.
//!
//! As in the report, levels are fractions of the commanded step, and times count from the step of
//! the command and include the transport delay.

use serde::{Serialize, Serializer};

use crate::run::Trace;

/// Half the width of the settling band, as a fraction of the step.
const SETTLED: f64 = 0.02;

/// Number of rows for which the command must be constant before and after a step.
const HELD_ROWS: usize = 5;

/// The first step of a command. A time is NaN if its level is not reached.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FirstStep {
    /// Time from 10 % to 90 %, s.
    pub rise_s: f64,
    /// Time to 90 %, s.
    pub t90_s: f64,
    /// Overshoot beyond the command, % of the step.
    pub overshoot_pct: f64,
    /// Time until the response stays within 2 %, s.
    pub settling_s: f64,
}

/// The figures of merit of a run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Figures {
    /// The first step, if the command has one.
    #[serde(flatten, serialize_with = "step_or_nulls")]
    pub step: Option<FirstStep>,
    /// Largest rate upward, deg/s.
    pub max_rate_deg_s: f64,
    /// Largest rate downward, deg/s; negative.
    pub min_rate_deg_s: f64,
    /// Largest magnitude of the duty, %.
    pub max_duty_pct: f64,
    /// Root mean square of command less angle, deg.
    pub error_rms_deg: f64,
}

impl Figures {
    /// Evaluates a trace.
    ///
    /// ```
    /// use actuator_web::{figures::Figures, run::run, scenario::Scenario};
    ///
    /// let trace = run(&Scenario::parse("model=black-box-1").unwrap()).unwrap();
    /// // 72 deg at 240 deg/s: the lag of 30 rad/s takes over 8 deg below the command of 90 deg.
    /// let step = Figures::of(&trace).step.unwrap();
    /// assert!((step.rise_s - 0.3).abs() < 0.01);
    /// assert!(step.overshoot_pct < 0.0);
    /// ```
    pub fn of(trace: &Trace) -> Self {
        let (command, angle) = (trace.column("command"), trace.column("angle_deg"));
        let squares = command.iter().zip(angle).map(|(c, a)| (c - a) * (c - a));
        let rate = || trace.column("rate_deg_s").iter().copied();
        let duty = trace.column("duty_pct").iter();
        Self {
            step: first_step(trace.column("t"), command, angle),
            max_rate_deg_s: rate().fold(0.0, f64::max),
            min_rate_deg_s: rate().fold(0.0, f64::min),
            max_duty_pct: duty.fold(0.0, |most, duty| f64::max(most, duty.abs())),
            error_rms_deg: (squares.sum::<f64>() / command.len().max(1) as f64).sqrt(),
        }
    }

    /// The figures by name, as JSON. A value that does not exist is `null`.
    pub fn to_json(&self) -> String {
        crate::json(self)
    }
}

/// Writes a missing step as one of which no level is reached.
fn step_or_nulls<S: Serializer>(step: &Option<FirstStep>, out: S) -> Result<S::Ok, S::Error> {
    let missing = FirstStep {
        rise_s: f64::NAN,
        t90_s: f64::NAN,
        overshoot_pct: f64::NAN,
        settling_s: f64::NAN,
    };
    step.unwrap_or(missing).serialize(out)
}

/// The first step of the command between two constant levels.
fn first_step(t: &[f64], command: &[f64], angle: &[f64]) -> Option<FirstStep> {
    let jump = command.windows(2).position(|pair| pair[0] != pair[1])?;
    let start = jump + 1;
    let from = command[jump];
    let to = command[start];
    let held = |rows: &[f64], level| rows.len() >= HELD_ROWS && rows.iter().all(|c| *c == level);
    let after = command.get(start..start + HELD_ROWS)?;
    if !(held(&command[..start], from) && held(after, to)) {
        return None;
    }
    let length = command[start..].iter().position(|c| *c != to);
    let end = length.map_or(command.len(), |length| start + length);
    let samples = t[start..end].iter().zip(&angle[start..end]);
    let share = |(time, angle): (&f64, &f64)| (time - t[start], (angle - from) / (to - from));
    Some(evaluate(&samples.map(share).collect::<Vec<_>>()))
}

/// Evaluates pairs of time and fraction of the step.
fn evaluate(shares: &[(f64, f64)]) -> FirstStep {
    let (t10_s, t90_s) = (reaches(shares, 0.1), reaches(shares, 0.9));
    let most = shares.iter().map(|s| s.1).fold(f64::NEG_INFINITY, f64::max);
    FirstStep {
        rise_s: t90_s - t10_s,
        t90_s,
        overshoot_pct: 100.0 * (most - 1.0),
        settling_s: settles(shares),
    }
}

/// When the response first reaches `level`.
fn reaches(shares: &[(f64, f64)], level: f64) -> f64 {
    match shares.iter().position(|s| s.1 >= level) {
        None => f64::NAN,
        Some(0) => shares[0].0,
        Some(after) => between(shares[after - 1], shares[after], level),
    }
}

/// When the response enters the settling band for the last time.
fn settles(shares: &[(f64, f64)]) -> f64 {
    let is_outside = |s: &(f64, f64)| (s.1 - 1.0).abs() > SETTLED;
    match shares.iter().rposition(is_outside) {
        None => shares.first().map_or(f64::NAN, |s| s.0),
        Some(last) => shares.get(last + 1).map_or(f64::NAN, |next| {
            let edge = 1.0 + SETTLED.copysign(shares[last].1 - 1.0);
            between(shares[last], *next, edge)
        }),
    }
}

/// The time at which the straight line between two samples crosses this level.
fn between(a: (f64, f64), b: (f64, f64), level: f64) -> f64 {
    a.0 + (b.0 - a.0) * (level - a.1) / (b.1 - a.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{run::run, scenario::Scenario};
    use host_sim::analysis::step_metrics::step_metrics;

    fn traced(text: &str) -> Trace {
        run(&Scenario::parse(text).unwrap()).unwrap()
    }

    #[test]
    fn the_first_step_is_that_of_the_report() {
        for text in [
            "model=black-box-1&input=doublet",
            "model=grey-box&preset=as-printed",
            "model=grey-box&preset=as-printed-strict",
            "preset=as-measured&input=variable-step",
            "plant=bench&load_torque_nm=0.2",
        ] {
            let trace = traced(text);
            let column = |name| trace.column(name);
            let report = step_metrics(
                column("t"),
                column("command"),
                column("angle_deg"),
                column("rate_deg_s"),
            );
            let (found, expected) = (Figures::of(&trace), report.steps[0]);
            let step = found.step.unwrap();
            let not_reached = |time: f64| (!time.is_nan()).then_some(time);
            assert_eq!(not_reached(step.rise_s), expected.rise_time_s, "{text}");
            assert_eq!(not_reached(step.t90_s), expected.t90_s, "{text}");
            assert_eq!(step.overshoot_pct, expected.overshoot_pct, "{text}");
            assert_eq!(
                not_reached(step.settling_s),
                expected.settling_time_s,
                "{text}"
            );
            assert_eq!(found.max_rate_deg_s, report.max_rate_deg_s);
            assert_eq!(found.min_rate_deg_s, report.min_rate_deg_s);
        }
    }

    #[test]
    fn a_sine_and_a_ramp_have_no_step() {
        for input in ["sine", "ramp", "chirp", "multisine"] {
            let figures = Figures::of(&traced(&format!("input={input}&duration_s=2")));
            assert_eq!(figures.step, None, "{input}");
        }
        assert_eq!(Figures::of(&Trace::default()).error_rms_deg, 0.0);
    }

    #[test]
    fn what_is_not_reached_is_null() {
        let slow = traced("model=black-box-1&rup=1");
        let json = Figures::of(&slow).to_json();
        assert!(json.contains(r#""rise_s":null"#), "{json}");
    }
}
