//! The frequency response of an actuator, measured by running it.
//!
//! A sum of sines at multiples of 0.25 Hz commands the actuator for one period in which it settles
//! and for another in which its angle is correlated with each of them. All have the same amplitude
//! up to 1 Hz; above, it falls with the frequency, so that no line requires more rate than the one
//! at 1 Hz. The rest of the response is nonlinear distortion or noise.

use core::f64::consts::{PI, TAU};

use model_core::actuator::Actuator;
use model_core::time::{PWM_PERIOD_TICKS, TICKS_PER_SECOND};
use serde::Serialize;

use crate::scenario::{Error, Scenario};

/// Ticks of one period: 4 s, a whole number of periods of every line.
const PERIOD: usize = 80_000;

/// The frequency of which all lines are multiples, Hz.
const BASE_HZ: f64 = TICKS_PER_SECOND as f64 / PERIOD as f64;

/// The lines as multiples of it: 0.25 Hz to 25 Hz, spaced about evenly on a logarithmic axis.
const LINES: [u16; 23] = [
    1, 2, 3, 4, 5, 6, 7, 9, 11, 13, 16, 19, 23, 27, 32, 38, 45, 53, 61, 70, 80, 90, 100,
];

/// The corner above which the amplitude falls, as a multiple of the base frequency.
const EVEN_UNTIL: f64 = 4.0;

/// One line of a response.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Its frequency, Hz.
    pub frequency_hz: f64,
    /// Gain from the command to the angle, dB.
    pub gain_db: f64,
    /// Phase, deg, unwrapped.
    pub phase_deg: f64,
}

/// A measured frequency response.
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    /// The lines, in the order of their frequencies.
    pub lines: Vec<Line>,
    /// Share of the power of the response at the lines, 0 to 1.
    pub linear_share: f64,
}

/// Measures the response of the actuator of a scenario, whose input is not used.
///
/// ```
/// use actuator_web::{frequency::measure, scenario::Scenario};
///
/// let response = measure(&Scenario::parse("model=black-box-1").unwrap()).unwrap();
/// // 30 rad/s
/// assert!((response.bandwidth_hz() - 4.775).abs() < 0.02);
/// ```
///
/// # Errors
/// [`Error::Parameter`] for parameters that exclude each other.
pub fn measure(scenario: &Scenario) -> Result<Response, Error> {
    let turn: Vec<f64> = (0..PERIOD)
        .map(|i| libm::sin(TAU * i as f64 / PERIOD as f64))
        .collect();
    let mut actuator = Actuator::try_new(&scenario.run.settings)?;
    let mut command = |tick: usize| {
        let lines = LINES.iter().enumerate();
        let sine = |(k, line): (usize, &u16)| {
            let place = tick * usize::from(*line) + start_of(k);
            amplitude(*line) * turn[place % PERIOD]
        };
        scenario.amplitude_deg * lines.map(sine).sum::<f64>()
    };
    let commands: Vec<f64> = (0..PERIOD).map(&mut command).collect();
    let mut angles = Vec::with_capacity(PERIOD / PWM_PERIOD_TICKS as usize);
    for pass in 0..2 {
        for (tick, command) in commands.iter().enumerate() {
            if pass == 1 && tick.is_multiple_of(PWM_PERIOD_TICKS as usize) {
                angles.push(actuator.reading().angle_deg);
            }
            actuator.advance(*command, 1).map_err(|_| Error::Command)?;
        }
    }
    Ok(evaluate(scenario, &turn, &angles))
}

/// Amplitude of a line as a share of the first one's.
fn amplitude(line: u16) -> f64 {
    f64::min(1.0, EVEN_UNTIL / f64::from(line))
}

/// Phase of line `k`, in ticks of the base period: the quadratic phases of Schroeder, which keep
/// the peak low.
fn start_of(k: usize) -> usize {
    PERIOD - (k * k * PERIOD / (2 * LINES.len())) % PERIOD
}

fn evaluate(scenario: &Scenario, turn: &[f64], angles: &[f64]) -> Response {
    let step = PERIOD / angles.len().max(1);
    let mut power = 0.0;
    let mut last_deg = 0.0;
    let mut line_of = |(k, line): (usize, &u16)| {
        let place = |i: usize| i * step * usize::from(*line) + start_of(k);
        let (mut sin, mut cos) = (0.0, 0.0);
        for (i, angle) in angles.iter().enumerate() {
            sin += angle * turn[place(i) % PERIOD];
            cos += angle * turn[(place(i) + PERIOD / 4) % PERIOD];
        }
        let scale = 2.0 / angles.len() as f64;
        let (re, im) = (sin * scale, cos * scale);
        power += (re * re + im * im) / 2.0;
        let frequency_hz = f64::from(*line) * BASE_HZ;
        // The known delay is removed while the phase is unwrapped: without it the phases of
        // neighbouring lines differ by less than half a turn.
        let delay_deg = 360.0 * frequency_hz * scenario.run.settings.setup.delay_s;
        let phase_deg = libm::atan2(im, re) * (180.0 / PI) + delay_deg;
        last_deg = phase_deg - 360.0 * libm::round((phase_deg - last_deg) / 360.0);
        Line {
            frequency_hz,
            gain_db: decibel(
                libm::sqrt(re * re + im * im) / amplitude(*line) / scenario.amplitude_deg,
            ),
            phase_deg: last_deg - delay_deg,
        }
    };
    let lines = LINES.iter().enumerate().map(&mut line_of).collect();
    Response {
        lines,
        linear_share: power / variance(angles),
    }
}

fn decibel(gain: f64) -> f64 {
    20.0 * libm::log10(gain)
}

fn variance(values: &[f64]) -> f64 {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / count
}

impl Response {
    /// The frequency at which the gain is 3 dB below that of the first line, Hz; NaN if there is
    /// none.
    pub fn bandwidth_hz(&self) -> f64 {
        let half_power_db = decibel(core::f64::consts::FRAC_1_SQRT_2);
        let below = |line: &Line| line.gain_db - self.lines[0].gain_db - half_power_db;
        let falls = self.lines.windows(2).find(|pair| below(&pair[1]) < 0.0);
        falls.map_or(f64::NAN, |pair| {
            let share = below(&pair[0]) / (below(&pair[0]) - below(&pair[1]));
            let ratio = pair[1].frequency_hz / pair[0].frequency_hz;
            pair[0].frequency_hz * libm::pow(ratio, share)
        })
    }

    /// The response by name, as JSON. A value that does not exist is `null`.
    pub fn to_json(&self) -> String {
        let column = |of: fn(&Line) -> f64| self.lines.iter().map(of).collect();
        crate::json(&Columns {
            frequency_hz: column(|line| line.frequency_hz),
            gain_db: column(|line| line.gain_db),
            phase_deg: column(|line| line.phase_deg),
            linear_share: self.linear_share,
            bandwidth_hz: self.bandwidth_hz(),
        })
    }
}

#[derive(Serialize)]
struct Columns {
    frequency_hz: Vec<f64>,
    gain_db: Vec<f64>,
    phase_deg: Vec<f64>,
    linear_share: f64,
    bandwidth_hz: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn response(text: &str) -> Response {
        measure(&Scenario::parse(text).unwrap()).unwrap()
    }

    #[test]
    fn the_first_order_model_has_the_gain_and_phase_of_its_pole_and_delay() {
        for delay_s in [0.0, 0.0175, 0.3] {
            let response = response(&format!("model=black-box-1&delay_s={delay_s}"));
            for line in &response.lines {
                let s = line.frequency_hz * TAU / 30.0;
                // The command is held for a tick, which adds half a tick of delay.
                let delay_deg = 360.0 * line.frequency_hz * (delay_s + 25e-6);
                let phase_deg = -s.atan().to_degrees() - delay_deg;
                let gain_db = -10.0 * (1.0 + s * s).log10();
                assert!((line.gain_db - gain_db).abs() < 1e-3, "{line:?} {gain_db}");
                assert!(
                    (line.phase_deg - phase_deg).abs() < 0.01,
                    "{line:?} {phase_deg}"
                );
            }
            // No limit is active, and the transient has decayed to e^(-30*4).
            assert!((response.linear_share - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn the_second_order_model_is_down_by_3_db_at_3_56_hz() {
        assert!((response("model=black-box-2").bandwidth_hz() - 3.56).abs() < 0.02);
    }

    #[test]
    fn the_board_with_its_encoder_stays_near_the_linear_loop() {
        // P 28.36 / (s^2 + 28.36 s + 8*28.36): 1.68 Hz without the sampling and the rate filter.
        let board = response("");
        let grey_box = response("model=grey-box");
        let apart = (board.bandwidth_hz() / grey_box.bandwidth_hz()).ln().abs();
        assert!(apart < 0.05, "{apart}");
        assert!(board.linear_share > 0.99, "{}", board.linear_share);
    }

    #[test]
    fn an_amplitude_beyond_the_limits_lowers_the_linear_share() {
        let share = response("model=black-box-1&amplitude_deg=60").linear_share;
        assert!(share < 0.99, "{share}");
    }

    #[test]
    fn an_actuator_that_does_not_move_has_no_response_and_no_bandwidth() {
        let still = response("model=black-box-1&pole_rad_s=0");
        assert!(still.linear_share.is_nan() && still.bandwidth_hz().is_nan());
        assert!(still.to_json().contains(r#""gain_db":[null,"#));
    }
}
