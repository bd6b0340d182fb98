//! The delay from command to angle by cross-correlation, without a model.

use super::{
    distributions::two_sided,
    slots::{Slots, lagged_products},
};

/// The delay according to the cross-correlation of the changes of command and angle.
///
/// The changes are used because the correlation of the values hardly decays with the lag (Ljung,
/// section 6.1 on pre-whitening). The peak includes the lag of the actuator and is an upper bound
/// of the delay; the first significant correlation is a lower bound to within one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DelayEstimate {
    /// The lag of the largest correlation, interpolated by a parabola, s.
    pub peak_s: f64,
    /// The correlation there.
    pub correlation: f64,
    /// The lag from which the correlation is outside its 99.9 % band up to the peak, s; `None` for
    /// a smooth command, whose changes are correlated with each other.
    pub onset_s: Option<f64>,
    /// One sample, s: the resolution.
    pub resolution_s: f64,
}

/// Correlation of adjacent changes below which a command is not smooth.
const SUDDEN: f64 = 0.3;
/// Longest delay, s.
const LONGEST_S: f64 = 0.5;

impl DelayEstimate {
    /// Estimates the delay of `angle` behind `command`. `None` without a change or without a
    /// significant correlation.
    ///
    /// ```
    /// use identification::statistics::delay::DelayEstimate;
    /// let time_s: Vec<f64> = (0..200).map(|i| f64::from(i) * 0.01).collect();
    /// let step = |from: usize| (0..200).map(|i| if i < from { 0.0 } else { 1.0 }).collect::<Vec<f64>>();
    /// let delay = DelayEstimate::of(&time_s, &step(50), &step(54)).unwrap();
    /// // The vertex of a parabola through three correlations of 199 changes, the mean taken off.
    /// assert!((delay.peak_s - 0.04).abs() < 1e-3 * delay.resolution_s);
    /// ```
    pub fn of(time_s: &[f64], command: &[f64], angle: &[f64]) -> Option<Self> {
        let mut slots = Slots::new(time_s, &[command, angle], LONGEST_S)?;
        slots.held(0);
        let [command, angle] = slots.columns.as_slice() else {
            return None;
        };
        let (command, angle) = (changes(command), changes(angle));
        let longest = slots.longest_lag.min(command.len() / 2);
        let products = lagged_products(&angle, &command, longest);
        let scale = |signal: &[f64]| lagged_products(signal, signal, 0).sums[0];
        let scale = (scale(&command) * scale(&angle)).sqrt();
        // A constant signal, except for rounding.
        if scale.is_nan() || scale <= 1e-12 {
            return None;
        }
        let rho: Vec<f64> = products.sums.iter().map(|sum| sum / scale).collect();
        let peak = (0..rho.len()).max_by(|&a, &b| rho[a].total_cmp(&rho[b]))?;
        let band = two_sided(0.999) / (products.pairs[0].max(1.0)).sqrt();
        if rho[peak] <= band {
            return None;
        }
        let inside = (0..peak).rev().find(|&lag| rho[lag] <= band);
        Some(Self {
            peak_s: (peak as f64 + vertex(&rho, peak)) * slots.step_s,
            correlation: rho[peak],
            onset_s: is_sudden(&command)
                .then(|| inside.map_or(0, |lag| lag + 1) as f64 * slots.step_s),
            resolution_s: slots.step_s,
        })
    }
}

/// Whether adjacent changes of a command are hardly correlated.
fn is_sudden(changes: &[f64]) -> bool {
    let products = lagged_products(changes, changes, 1);
    products.sums[1] < SUDDEN * products.sums[0]
}

fn changes(signal: &[f64]) -> Vec<f64> {
    signal.windows(2).map(|w| w[1] - w[0]).collect()
}

/// The offset of the vertex of the parabola through a maximum and its neighbours.
fn vertex(values: &[f64], peak: usize) -> f64 {
    let neighbour = |i: Option<usize>| i.and_then(|i| values.get(i)).copied();
    let before = neighbour(peak.checked_sub(1));
    let (Some(before), Some(after)) = (before, neighbour(Some(peak + 1))) else {
        return 0.0;
    };
    let curvature = before - 2.0 * values[peak] + after;
    if curvature < 0.0 {
        (0.5 * (before - after) / curvature).clamp(-0.5, 0.5)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::{super::tests::white, *};

    #[test]
    fn the_delay_of_a_lag_is_between_onset_and_peak() {
        const STEP_S: f64 = 0.004;
        let time_s: Vec<f64> = (0..2000).map(|i| f64::from(i) * STEP_S).collect();
        // A binary sequence through 5 samples of delay and a lag of 30 rad/s.
        let flips = white(200, 1);
        let command: Vec<f64> = (0..2000usize)
            .map(|i| 5.0 * flips[i / 10].signum())
            .collect();
        let decay = (-30.0 * STEP_S).exp();
        let mut state = command[0];
        let noise = white(2000, 2);
        let angle: Vec<f64> = (0..2000usize)
            .map(|i| {
                let delayed = command[i.saturating_sub(5)];
                let now = state;
                state = delayed + (state - delayed) * decay;
                now + 0.05 * noise[i]
            })
            .collect();
        let delay = DelayEstimate::of(&time_s, &command, &angle).expect("it moves");
        // The state responds one sample after the delayed command.
        assert!(
            delay
                .onset_s
                .is_some_and(|s| (s - 6.0 * STEP_S).abs() < 1e-9),
            "{delay:?}"
        );
        assert!(delay.peak_s >= 5.5 * STEP_S && delay.peak_s < 8.0 * STEP_S);
    }

    #[test]
    fn a_constant_or_unrelated_angle_has_no_delay() {
        let time_s: Vec<f64> = (0..500).map(|i| f64::from(i) * 0.02).collect();
        assert_eq!(DelayEstimate::of(&time_s, &time_s, &[1.0; 500]), None);
        assert_eq!(DelayEstimate::of(&[], &[], &[]), None);
        let unrelated = DelayEstimate::of(&time_s, &white(500, 1), &white(500, 9));
        assert_eq!(unrelated, None);
    }
}
