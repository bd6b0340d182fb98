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

/// The step metrics of a trace.
#[derive(Debug, Clone, PartialEq)]
pub struct StepMetrics {
    /// The steps in order.
    pub steps: Vec<Step>,
    /// Largest rate upward, deg/s.
    pub max_rate_deg_s: f64,
    /// Largest rate downward, deg/s; negative.
    pub min_rate_deg_s: f64,
}

/// Evaluates every step of a piecewise constant command. Samples beyond the end of the shortest
/// column are ignored; the response is interpolated linearly between samples.
///
/// ```
/// use host_sim::analysis::step_metrics::step_metrics;
/// let t = [0.0, 1.0, 2.0, 3.0];
/// let found = step_metrics(&t, &[0.0, 10.0, 10.0, 10.0], &[0.0, 0.0, 10.0, 10.0], &[0.0; 4]);
/// assert_eq!(found.steps[0].t90_s, Some(0.9));
/// assert_eq!(found.steps[0].overshoot_pct, 0.0);
/// ```
pub fn step_metrics(
    t_s: &[f64],
    command_deg: &[f64],
    angle_deg: &[f64],
    rate_deg_s: &[f64],
) -> StepMetrics {
    let lengths = [
        t_s.len(),
        command_deg.len(),
        angle_deg.len(),
        rate_deg_s.len(),
    ];
    let len = lengths.into_iter().min().unwrap_or(0);
    let starts: Vec<usize> = (1..len)
        .filter(|i| command_deg[*i] != command_deg[i - 1])
        .collect();
    let ends = starts.iter().skip(1).copied().chain([len]);
    let steps = starts.iter().zip(ends).map(|(&start, end)| {
        let (from_deg, to_deg) = (command_deg[start - 1], command_deg[start]);
        let samples = t_s[start..end].iter().zip(&angle_deg[start..end]);
        let shares: Vec<(f64, f64)> = samples
            .map(|(t, angle)| (t - t_s[start], (angle - from_deg) / (to_deg - from_deg)))
            .collect();
        evaluate(t_s[start], from_deg, to_deg, &shares)
    });
    let rate_deg_s = &rate_deg_s[..len];
    StepMetrics {
        steps: steps.collect(),
        max_rate_deg_s: rate_deg_s.iter().copied().fold(0.0, f64::max),
        min_rate_deg_s: rate_deg_s.iter().copied().fold(0.0, f64::min),
    }
}

/// Evaluates one step from pairs of time since the step and fraction of the step.
fn evaluate(time_s: f64, from_deg: f64, to_deg: f64, shares: &[(f64, f64)]) -> Step {
    let t10_s = reaches(shares, 0.1);
    let t90_s = reaches(shares, 0.9);
    let most = shares.iter().map(|s| s.1).fold(f64::NEG_INFINITY, f64::max);
    Step {
        time_s,
        from_deg,
        to_deg,
        rise_time_s: t10_s.zip(t90_s).map(|(t10, t90)| t90 - t10),
        t90_s,
        overshoot_pct: 100.0 * (most - 1.0),
        settling_time_s: settles(shares),
    }
}

/// When the response first reaches `level`.
fn reaches(shares: &[(f64, f64)], level: f64) -> Option<f64> {
    let after = shares.iter().position(|s| s.1 >= level)?;
    if after == 0 {
        return Some(shares[0].0);
    }
    Some(between(shares[after - 1], shares[after], level))
}

/// When the response enters the settling band for the last time.
fn settles(shares: &[(f64, f64)]) -> Option<f64> {
    // NaN is not inside.
    let inside = |s: &(f64, f64)| (s.1 - 1.0).abs() <= SETTLING_BAND;
    let Some(last) = shares.iter().rposition(|s| !inside(s)) else {
        return shares.first().map(|s| s.0);
    };
    let next = shares.get(last + 1)?;
    let edge = if shares[last].1 > 1.0 {
        1.0 + SETTLING_BAND
    } else {
        1.0 - SETTLING_BAND
    };
    Some(between(shares[last], *next, edge))
}

/// The time at which the straight line between two samples crosses this level.
fn between(a: (f64, f64), b: (f64, f64), level: f64) -> f64 {
    a.0 + (b.0 - a.0) * (level - a.1) / (b.1 - a.1)
}

#[cfg(test)]
#[path = "step_metrics_tests.rs"]
mod tests;
