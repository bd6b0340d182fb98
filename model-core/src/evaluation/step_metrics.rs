//! Figures of merit of steps: rise time, overshoot, settling time and the largest rates.
//!
//! Levels are fractions of the commanded step. Times count from the step of the command and include
//! the transport delay. A step ends at the next one.

/// Half the width of the settling band, as a fraction of the step.
pub const SETTLING_BAND: f64 = 0.02;

/// One step of a command and its response.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Time of the step, s.
    pub time_s: f64,
    /// Command before it, deg.
    pub from_deg: f64,
    /// Command after it, deg.
    pub to_deg: f64,
    /// Time from 10 % to 90 % of the step, s. `None` if 90 % is never reached.
    pub rise_time_s: Option<f64>,
    /// Time from the step to 90 %, s. `None` if it is never reached.
    pub t90_s: Option<f64>,
    /// Overshoot beyond the command, % of the step. Negative if the command is not reached.
    pub overshoot_pct: f64,
    /// Time from the step until the response stays within 2 %, s. `None` if it does not.
    pub settling_time_s: Option<f64>,
}

/// Evaluates every step of a piecewise constant command. Samples beyond the end of the shortest
/// column are ignored; the response is interpolated linearly between samples.
///
/// ```
/// use model_core::evaluation::step_metrics::steps;
///
/// let t = [0.0, 1.0, 2.0, 3.0];
/// let step = steps(&t, &[0.0, 10.0, 10.0, 10.0], &[0.0, 0.0, 10.0, 10.0]).next().unwrap();
/// assert_eq!(step.t90_s, Some(0.9));
/// assert_eq!(step.overshoot_pct, 0.0);
/// ```
pub fn steps<'a>(
    t_s: &'a [f64],
    command_deg: &'a [f64],
    angle_deg: &'a [f64],
) -> impl Iterator<Item = Step> + 'a {
    let len = t_s.len().min(command_deg.len()).min(angle_deg.len());
    let next = move |after: usize| (after..len).find(|i| command_deg[*i] != command_deg[i - 1]);
    let mut start = next(1);
    core::iter::from_fn(move || {
        let from = start?;
        start = next(from + 1);
        let to = start.unwrap_or(len);
        let before_deg = command_deg[from - 1];
        Some(
            Response {
                t_s: &t_s[from..to],
                angle_deg: &angle_deg[from..to],
                from_deg: before_deg,
                to_deg: command_deg[from],
            }
            .evaluate(),
        )
    })
}

/// The largest rates downward, zero or negative, and upward, zero or positive, deg/s.
///
/// ```
/// use model_core::evaluation::step_metrics::rate_extremes;
/// assert_eq!(rate_extremes(&[3.0, 7.0, 1.0]), (0.0, 7.0));
/// ```
pub fn rate_extremes(rate_deg_s: &[f64]) -> (f64, f64) {
    let rates = rate_deg_s.iter().copied();
    (rates.clone().fold(0.0, f64::min), rates.fold(0.0, f64::max))
}

/// The samples from a step of the command to the next one.
struct Response<'a> {
    t_s: &'a [f64],
    angle_deg: &'a [f64],
    from_deg: f64,
    to_deg: f64,
}

impl Response<'_> {
    fn evaluate(&self) -> Step {
        let t10_s = self.reaches(0.1);
        let t90_s = self.reaches(0.9);
        let shares = (0..self.t_s.len()).map(|i| self.at(i).1);
        let most = shares.fold(f64::NEG_INFINITY, f64::max);
        Step {
            time_s: self.t_s[0],
            from_deg: self.from_deg,
            to_deg: self.to_deg,
            rise_time_s: t10_s.zip(t90_s).map(|(t10, t90)| t90 - t10),
            t90_s,
            overshoot_pct: 100.0 * (most - 1.0),
            settling_time_s: self.settles(),
        }
    }

    /// Time since the step and fraction of the step of a sample.
    fn at(&self, i: usize) -> (f64, f64) {
        let share = (self.angle_deg[i] - self.from_deg) / (self.to_deg - self.from_deg);
        (self.t_s[i] - self.t_s[0], share)
    }

    /// When the response first reaches `level`.
    fn reaches(&self, level: f64) -> Option<f64> {
        let after = (0..self.t_s.len()).find(|i| self.at(*i).1 >= level)?;
        Some(match after {
            0 => 0.0,
            _ => between(self.at(after - 1), self.at(after), level),
        })
    }

    /// When the response enters the settling band for the last time.
    fn settles(&self) -> Option<f64> {
        // NaN is not inside.
        let inside = |i: &usize| (self.at(*i).1 - 1.0).abs() <= SETTLING_BAND;
        let Some(last) = (0..self.t_s.len()).rev().find(|i| !inside(i)) else {
            return Some(0.0);
        };
        let (outside, next) = (self.at(last), last + 1);
        let edge = 1.0
            + if outside.1 > 1.0 {
                SETTLING_BAND
            } else {
                -SETTLING_BAND
            };
        (next < self.t_s.len()).then(|| between(outside, self.at(next), edge))
    }
}

/// The time at which the straight line between two samples crosses this level.
fn between(a: (f64, f64), b: (f64, f64), level: f64) -> f64 {
    a.0 + (b.0 - a.0) * (level - a.1) / (b.1 - a.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    #[test]
    fn each_step_counts_from_its_own_command() {
        let t: Vec<f64> = (0..40).map(|i| f64::from(i) * 0.1).collect();
        let command: Vec<f64> = (0..40).map(|i| [0.0, 10.0, -10.0, -10.0][i / 10]).collect();
        let found: Vec<Step> = steps(&t, &command, &command).collect();
        let levels: Vec<_> = found.iter().map(|s| (s.from_deg, s.to_deg)).collect();
        assert_eq!(levels, [(0.0, 10.0), (10.0, -10.0)]);
        assert!(found.iter().all(|s| s.settling_time_s == Some(0.0)));
        assert!(found.iter().all(|s| s.t90_s == Some(0.0)));
    }

    #[test]
    fn overshoot_is_relative_to_the_step_and_in_its_direction() {
        let t = [0.0, 1.0, 2.0, 3.0, 4.0];
        let command = [0.0, -20.0, -20.0, -20.0, -20.0];
        let step = steps(&t, &command, &[0.0, 0.0, -25.0, -20.0, -20.0]);
        let step = step.last().unwrap();
        assert!((step.overshoot_pct - 25.0).abs() < 1e-12);
        // From -25 to -20 in one second: inside the band of 0.4 deg at 4.6/5 of it.
        assert!((step.settling_time_s.unwrap() - 1.92).abs() < 1e-12);
    }

    proptest! {
        #[test]
        fn no_trace_causes_a_panic(
            t in prop::collection::vec(any::<f64>(), 0..9),
            command in prop::collection::vec(any::<f64>(), 0..9),
            angle in prop::collection::vec(any::<f64>(), 0..9),
        ) {
            steps(&t, &command, &angle).for_each(drop);
        }
    }
}
