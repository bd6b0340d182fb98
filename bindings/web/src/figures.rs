//! Figures of merit of a run: those of its first step as in the report, the largest rates and the
//! tracking error.

use model_core::evaluation::step_metrics::{Step, rate_extremes, steps};
use serde::Serialize;

use crate::run::Trace;

/// Number of rows for which the command must be constant before and after a step.
const HELD_ROWS: usize = 5;

/// The figures of merit of a run. Those of a step are `None` if the command has no step or the
/// level is not reached.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Figures {
    /// Time from 10 % to 90 % of the first step, s.
    pub rise_s: Option<f64>,
    /// Time to 90 % of it, s.
    pub t90_s: Option<f64>,
    /// Overshoot beyond the command, % of the step.
    pub overshoot_pct: Option<f64>,
    /// Time until the response stays within 2 %, s.
    pub settling_s: Option<f64>,
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
    /// let trace = run(&Scenario::parse("model=black-box-1").unwrap(), |_| true).unwrap();
    /// // 72 deg at 240 deg/s: the lag of 30 rad/s takes over 8 deg below the command of 90 deg.
    /// let figures = Figures::of(&trace);
    /// assert!((figures.rise_s.unwrap() - 0.3).abs() < 0.01);
    /// assert!(figures.overshoot_pct.unwrap() < 0.0);
    /// ```
    pub fn of(trace: &Trace) -> Self {
        let (command, angle) = (trace.column("command_deg"), trace.column("angle_deg"));
        let step = first_step(trace.column("time_s"), command, angle);
        let (min_rate_deg_s, max_rate_deg_s) = rate_extremes(trace.column("rate_deg_s"));
        let duty = trace.column("duty_pct").iter();
        let squares = command.iter().zip(angle).map(|(c, a)| (c - a) * (c - a));
        Self {
            rise_s: step.and_then(|step| step.rise_time_s),
            t90_s: step.and_then(|step| step.t90_s),
            overshoot_pct: step.map(|step| step.overshoot_pct),
            settling_s: step.and_then(|step| step.settling_time_s),
            max_rate_deg_s,
            min_rate_deg_s,
            max_duty_pct: duty.fold(0.0, |most, duty| f64::max(most, duty.abs())),
            error_rms_deg: (squares.sum::<f64>() / command.len().max(1) as f64).sqrt(),
        }
    }

    /// The figures by name, as JSON. A value that does not exist is `null`.
    pub fn to_json(&self) -> String {
        crate::json(self)
    }
}

/// The first step of the command, if it is between two constant levels.
fn first_step(t: &[f64], command: &[f64], angle: &[f64]) -> Option<Step> {
    let start = 1 + command.windows(2).position(|pair| pair[0] != pair[1])?;
    let is_held = |rows: &[f64]| rows.windows(2).all(|pair| pair[0] == pair[1]);
    let after = command.get(start..start + HELD_ROWS)?;
    let held = start >= HELD_ROWS && is_held(after);
    held.then(|| steps(t, command, angle).next())?
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{run::run, scenario::Scenario};

    fn traced(text: &str) -> Trace {
        run(&Scenario::parse(text).unwrap(), |_| true).unwrap()
    }

    #[test]
    fn a_sine_and_a_ramp_have_no_step() {
        for input in ["sine", "ramp", "chirp", "multisine"] {
            let figures = Figures::of(&traced(&format!("input={input}&duration_s=2")));
            assert_eq!(figures.overshoot_pct, None, "{input}");
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
