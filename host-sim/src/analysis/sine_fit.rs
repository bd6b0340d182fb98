//! Gain and phase at one frequency from samples.

use super::frequency::decibel;
use std::f64::consts::TAU;

/// The least-squares fit of a sine to samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SineFit {
    /// Amplitude, in the unit of the samples.
    pub amplitude: f64,
    /// Phase at time zero, deg, in -180..=180.
    pub phase_deg: f64,
    /// Offset, in the unit of the samples.
    pub offset: f64,
    /// Root mean square of the residuals.
    pub residual_rms: f64,
}

impl SineFit {
    /// Gain in dB and phase in -180..=180 deg of this output over `input`.
    pub fn over(&self, input: &Self) -> (f64, f64) {
        let phase = self.phase_deg - input.phase_deg;
        let phase = phase - 360.0 * (phase / 360.0).round();
        (decibel(self.amplitude / input.amplitude), phase)
    }
}

/// Fits `y = amplitude sin(2 pi frequency_hz t + phase) + offset` to the last whole periods of the
/// samples: the three-parameter fit of IEEE Std 1057, section on the known frequency.
///
/// The samples need not be equally spaced; `t_s` is ascending. `None` if the samples cover less
/// than one period or a value is not finite.
///
/// ```
/// use host_sim::analysis::sine_fit::fit;
/// let t: Vec<f64> = (0..1000).map(|i| i as f64 * 1e-3).collect();
/// let y: Vec<f64> = t.iter().map(|t| 2.0 * (31.4159265 * t).cos() + 1.0).collect();
/// let sine = fit(&t, &y, 5.0).unwrap();
/// assert!((sine.amplitude - 2.0).abs() < 1e-6 && (sine.phase_deg - 90.0).abs() < 1e-5);
/// ```
pub fn fit(t_s: &[f64], y: &[f64], frequency_hz: f64) -> Option<SineFit> {
    let len = t_s.len().min(y.len());
    let first = first_of_whole_periods(&t_s[..len], frequency_hz)?;
    let (t_s, y) = (&t_s[first..len], &y[first..len]);
    let rows = || {
        let samples = t_s.iter().zip(y);
        samples.map(|(t, y)| {
            let (sin, cos) = (TAU * frequency_hz * t).sin_cos();
            [sin, cos, 1.0, *y]
        })
    };
    let [a, b, offset] = least_squares(rows())?;
    let squares: f64 = rows()
        .map(|[sin, cos, one, y]| (y - a * sin - b * cos - offset * one).powi(2))
        .sum();
    Some(SineFit {
        amplitude: a.hypot(b),
        phase_deg: b.atan2(a).to_degrees(),
        offset,
        residual_rms: (squares / y.len() as f64).sqrt(),
    })
}

/// The index from which the samples cover the most whole periods.
fn first_of_whole_periods(t_s: &[f64], frequency_hz: f64) -> Option<usize> {
    let [first, .., before, last] = t_s else {
        return None;
    };
    // The last sample represents the time up to the next one.
    let step = last - before;
    let periods = ((last - first + step) * frequency_hz + 1e-9).floor();
    if !(periods >= 1.0 && frequency_hz > 0.0) {
        return None;
    }
    // Half a step of tolerance for rounding.
    let start = last + 0.5 * step - periods / frequency_hz;
    Some(t_s.partition_point(|t| *t < start))
}

/// Solves the normal equations of rows `[x0, x1, x2, y]` by Gaussian elimination. Over whole
/// periods they are nearly diagonal, so that no pivoting is needed.
fn least_squares(rows: impl Iterator<Item = [f64; 4]>) -> Option<[f64; 3]> {
    let mut m = [[0.0; 4]; 3];
    for row in rows {
        for (i, line) in m.iter_mut().enumerate() {
            for (sum, value) in line.iter_mut().zip(row) {
                *sum += row[i] * value;
            }
        }
    }
    for i in 0..3 {
        let pivot = m[i];
        for (_, line) in m.iter_mut().enumerate().filter(|(j, _)| *j != i) {
            let factor = line[i] / pivot[i];
            for (value, above) in line.iter_mut().zip(pivot) {
                *value -= factor * above;
            }
        }
    }
    let solution = [0, 1, 2].map(|i| m[i][3] / m[i][i]);
    solution.iter().all(|x| x.is_finite()).then_some(solution)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_sine_with_an_offset_is_recovered(
            amplitude in 0.01..100.0f64,
            phase_deg in -179.0..179.0f64,
            offset in -100.0..100.0f64,
            frequency_hz in 0.5..40.0f64,
        ) {
            let t: Vec<f64> = (0..3000).map(|i| f64::from(i) * 1e-3).collect();
            let y: Vec<f64> = t
                .iter()
                .map(|t| amplitude * (TAU * frequency_hz * t + phase_deg.to_radians()).sin() + offset)
                .collect();
            let sine = fit(&t, &y, frequency_hz).unwrap();
            // Rounding of 1e-16 in 3000 sums of squares, relative to the larger of both parts.
            let tolerance = 1e-10 * (amplitude + offset.abs());
            prop_assert!((sine.amplitude - amplitude).abs() < tolerance);
            prop_assert!((sine.offset - offset).abs() < tolerance);
            prop_assert!((sine.phase_deg - phase_deg).abs() < 1e2 * tolerance / amplitude);
            prop_assert!(sine.residual_rms < tolerance);
        }

        #[test]
        fn no_samples_cause_a_panic(
            t in prop::collection::vec(any::<f64>(), 0..12),
            y in prop::collection::vec(any::<f64>(), 0..12),
            frequency_hz in any::<f64>(),
        ) {
            let _ = fit(&t, &y, frequency_hz);
        }
    }

    #[test]
    fn less_than_a_period_gives_no_fit() {
        let t: Vec<f64> = (0..99).map(|i| f64::from(i) * 1e-2).collect();
        assert_eq!(fit(&t, &t, 1.0), None);
        assert_eq!(fit(&[], &[], 1.0), None);
    }

    #[test]
    fn a_harmonic_appears_in_the_residual_only() {
        let t: Vec<f64> = (0..1777).map(|i| f64::from(i) * 1e-3).collect();
        let y: Vec<f64> = t
            .iter()
            .map(|t| (TAU * t).sin() + 0.5 * (3.0 * TAU * t).cos())
            .collect();
        let sine = fit(&t, &y, 1.0).unwrap();
        // Orthogonal over whole periods, to rounding.
        assert!((sine.amplitude - 1.0).abs() < 1e-9 && sine.phase_deg.abs() < 1e-9);
        assert!((sine.residual_rms - 0.5 / 2.0_f64.sqrt()).abs() < 1e-9);
    }

    #[test]
    fn gain_and_phase_are_the_ratio_of_output_and_input() {
        let sine = |amplitude, phase_deg| SineFit {
            amplitude,
            phase_deg,
            offset: 0.0,
            residual_rms: 0.0,
        };
        let (gain_db, phase_deg) = sine(1.0, -170.0).over(&sine(10.0, 100.0));
        assert!((gain_db + 20.0).abs() < 1e-12);
        assert!((phase_deg - 90.0).abs() < 1e-12);
    }
}
