//! Gain and phase of sines in recorded motions.

use core::f64::consts::TAU;

/// Gain that defines the bandwidth: half the power, -3.0103 dB.
pub const HALF_POWER_DB: f64 = -3.010_299_956_639_812;

/// A gain in dB.
pub fn decibel(gain: f64) -> f64 {
    20.0 * libm::log10(gain)
}

/// Removes the jumps by whole turns from a sequence of angles; the first angle stays. NaN is
/// skipped.
pub fn unwrap_deg(angles_deg: &mut [f64]) {
    let mut last = f64::NAN;
    for angle_deg in angles_deg {
        if !last.is_nan() {
            *angle_deg -= 360.0 * libm::round((*angle_deg - last) / 360.0);
        }
        if !angle_deg.is_nan() {
            last = *angle_deg;
        }
    }
}

/// Amplitude and phase, deg, of the sine with this number of periods in equally spaced samples. The
/// phase is that at the first sample. A constant and harmonics do not change the result.
///
/// ```
/// use model_core::evaluation::frequency_response::sine;
///
/// let samples = [3.0, 1.0, -1.0, 1.0];
/// let (amplitude, phase_deg) = sine(&samples, 1);
/// assert!((amplitude - 2.0).abs() < 1e-12 && (phase_deg - 90.0).abs() < 1e-12);
/// ```
pub fn sine(samples: &[f64], periods: u32) -> (f64, f64) {
    let count = samples.len() as f64;
    let (mut of_cosine, mut of_sine) = (0.0, 0.0);
    for (index, sample) in samples.iter().enumerate() {
        let phase = TAU * f64::from(periods) * index as f64 / count;
        of_cosine += sample * libm::cos(phase);
        of_sine += sample * libm::sin(phase);
    }
    let amplitude = 2.0 * libm::hypot(of_cosine, of_sine) / count;
    (amplitude, libm::atan2(of_cosine, of_sine).to_degrees())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_sine_is_found_beside_a_constant_and_a_harmonic(
            amplitude in 0.01..100.0f64, turns in -0.49..0.49f64, constant in -100.0..100.0f64,
            periods in 1..40u32,
        ) {
            let samples: [f64; 1000] = core::array::from_fn(|i| {
                let x = TAU * f64::from(periods) * i as f64 / 1e3;
                amplitude * libm::sin(x + TAU * turns) + constant + libm::cos(3.0 * x)
            });
            let found = sine(&samples, periods);
            // Rounding of 1e-16 in 1000 sums, relative to the larger of all parts.
            let tolerance = 1e-10 * (amplitude + constant.abs() + 1.0);
            prop_assert!((found.0 - amplitude).abs() < tolerance);
            prop_assert!((found.1 - 360.0 * turns).abs() < 100.0 * tolerance / amplitude);
        }
    }
}
