//! The margins of the loop as it runs: a sine is added to the duty, and the response of the duty
//! that the control law commands is the gain around the loop, through encoder and back-EMF alike.
//!
//! With the control law's duty `u` and the sine `d`, the bridge gets `u + d`, and `u = -L (u + d)`.
//! The shaft turns slowly meanwhile, so that the dry friction is constant.

use core::f64::consts::{LN_10, TAU};

use firmware::timing::CONTROL_PERIOD_MS;
use host_sim::analysis::linear_models::{Loop, Motor, Timing};
use host_sim::analysis::loop_gain;
use model_core::control::parameters::ControlParameters;
use model_core::control::pwm_timer::PWM_COUNTS;
use model_core::plant::board::ENCODER_DELAY_S;
use model_core::time::{CONTROL_PERIOD_S, CONTROL_RATE_HZ};
use num_complex::Complex64;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::bench::Bench;
use super::{SEEDS, Setup};

/// Amplitude of the sine, %, at this frequency, Hz: its rate stays below that of the shaft, the
/// response is above the noise of the duty, and the current that it adds to that of the commanded
/// duty is not reported as implausible.
fn amplitude_pct(frequency_hz: f64) -> f64 {
    (frequency_hz / 2.0).clamp(4.0, 7.0)
}

/// Rate of the shaft, deg/s, another one for each seed: the counts of the encoder, 137 to 174 a
/// second, alias with the control periods to another frequency in each.
fn rate_deg_s(seed: u64) -> f64 {
    12.0 + 0.37 * seed as f64
}

/// Where it starts, deg.
const START_DEG: f64 = -55.0;

/// Control periods before the sine, until it is steady, and in which it is measured.
const SETTLING: u32 = 2 * CONTROL_RATE_HZ;
const TRANSIENT: u32 = 2 * CONTROL_RATE_HZ;
const MEASURED: u32 = 5 * CONTROL_RATE_HZ;

/// Turns of the sine while it is measured: 1.4 to 93 Hz, 10 % apart.
fn lines() -> Vec<u32> {
    let mut lines: Vec<_> = (0..45)
        .map(|line| (7.0 * 1.1_f64.powi(line)) as u32)
        .collect();
    lines.dedup();
    lines
}

/// Margins of a loop.
#[derive(Debug, Clone, Copy)]
pub struct Margins {
    /// Phase margin, deg.
    pub phase_deg: f64,
    /// Frequency of the phase margin, Hz.
    pub crossing_hz: f64,
    /// Gain margin, dB.
    pub gain_db: f64,
}

/// The least margins of a loop with the drives of the seeds; NaN where it has none up to 93 Hz.
/// Between two lines gain, phase and frequency are linear in their logarithms.
pub fn margins(setup: &Setup, bench: Bench) -> Margins {
    let lines = lines().into_iter();
    let gains: Vec<_> = lines.map(|turns| gain((setup, bench), turns)).collect();
    let mut least = Margins {
        phase_deg: f64::NAN,
        crossing_hz: f64::NAN,
        gain_db: f64::NAN,
    };
    let level = |value: Complex64| value.norm().ln();
    for pair in gains.windows(2) {
        let [(low_hz, low), (high_hz, high)] = [pair[0], pair[1]];
        if (low.norm() > 1.0) != (high.norm() > 1.0) {
            let share = level(low) / (level(low) - level(high));
            let phase = (-low * (high / low).powf(share)).arg();
            let phase_deg = phase.to_degrees().abs();
            if least.phase_deg.is_nan() || phase_deg < least.phase_deg {
                least.phase_deg = phase_deg;
                least.crossing_hz = low_hz * (high_hz / low_hz).powf(share);
            }
        }
        let [before, behind] = [-low, -high].map(Complex64::arg);
        if before * behind < 0.0 && (before - behind).abs() < TAU / 2.0 {
            let share = before / (before - behind);
            let level = level(low) + share * (level(high) - level(low));
            // The least of a number and NaN is the number.
            least.gain_db = least.gain_db.min((20.0 * level / LN_10).abs());
        }
    }
    least
}

/// Those of the linear model of the paper's loop, with the delay of the encoder.
///
/// # Panics
/// If the model is not valid.
pub fn expected() -> Margins {
    let timing = Timing {
        duty_delay_s: Timing::default().duty_delay_s + ENCODER_DELAY_S,
        ..Timing::default()
    };
    let papers = Loop::sampled(&Motor::default(), &ControlParameters::DEFAULT, &timing);
    let margins = loop_gain::Margins::of(&papers.expect("in range"));
    let (phase, gain) = (margins.phase_deg, margins.gain_db);
    let (phase, gain) = (phase.expect("a crossing"), gain.expect("a crossing"));
    Margins {
        phase_deg: phase.value,
        crossing_hz: phase.frequency_hz,
        gain_db: gain.value,
    }
}

/// Frequency, Hz, of a sine of so many turns, and the gain around the loop, the mean over the
/// seeds.
fn gain(drives: (&Setup, Bench), turns: u32) -> (f64, Complex64) {
    let frequency_hz = f64::from(turns) / (f64::from(MEASURED) * CONTROL_PERIOD_S);
    let seeds = (0..SEEDS).into_par_iter();
    let sum: Complex64 = seeds.map(|seed| once(drives, seed, frequency_hz)).sum();
    (frequency_hz, sum / SEEDS as f64)
}

fn once((setup, bench): (&Setup, Bench), seed: u64, frequency_hz: f64) -> Complex64 {
    // A target in each control period.
    let mut drive = bench.drive(setup, seed, CONTROL_PERIOD_MS);
    let (mut commanded, mut bridge) = (Complex64::ZERO, Complex64::ZERO);
    for period in 0..SETTLING + TRANSIENT + MEASURED {
        let since = period.saturating_sub(SETTLING);
        let moved_deg = rate_deg_s(seed) * f64::from(since) * CONTROL_PERIOD_S;
        drive.target(START_DEG + moved_deg);
        let phase = TAU * frequency_hz * f64::from(since) * CONTROL_PERIOD_S;
        let added_pct = bench.duty_share() * amplitude_pct(frequency_hz) * phase.sin();
        let counts = (f64::from(PWM_COUNTS) * added_pct / 100.0).round();
        let (duty_pct, _) = drive.step_with(counts as i32);
        if since >= TRANSIENT {
            let turn = Complex64::cis(-phase);
            commanded += duty_pct * turn;
            bridge += (duty_pct + 100.0 * counts / f64::from(PWM_COUNTS)) * turn;
        }
    }
    -commanded / bridge
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SETUPS;

    #[test]
    fn the_measured_margins_of_the_papers_loop_are_those_of_its_linear_model() {
        let (found, expected) = (margins(&SETUPS[0], Bench::USUAL), expected());
        // What a tuning promises of its prediction: 2 deg and 1 dB.
        println!("{found:?}, expected {expected:?}");
        assert!((found.phase_deg - expected.phase_deg).abs() < 2.0);
        assert!((found.gain_db - expected.gain_db).abs() < 1.0);
    }
}
