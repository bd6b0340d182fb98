//! The measured frequency response: the actuator is driven by one sine after the other.

use std::f64::consts::TAU;

use super::models::Model;
use crate::error::Error;
use model_core::{
    actuator::Actuator,
    evaluation::frequency_response::{HALF_POWER_DB, decibel, sine},
    time::{CONTROL_PERIOD_TICKS, CONTROL_RATE_HZ, seconds},
};

/// The frequencies of the sweep, Hz; one of them is the paper's 30 rad/s. At 20 Hz the motion of
/// the board is one encoder count: higher frequencies cannot be measured.
pub const FREQUENCIES_HZ: [f64; 12] = [
    0.2,
    0.5,
    1.0,
    1.5,
    2.0,
    3.0,
    4.0,
    30.0 / TAU,
    7.0,
    10.0,
    14.0,
    20.0,
];

/// Minimum measuring time, s, and settling time: 28 time constants of the slowest closed-loop
/// pole, 7 1/s. The encoder's rounding differs between the periods of a sine.
const SHORTEST_S: f64 = 4.0;
/// Iterations of the search for the bandwidth. The gain is almost a straight line between two
/// frequencies: each iteration reduces the error to less than a tenth.
const REFINEMENTS: usize = 3;

/// One point of a response.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Its frequency, Hz.
    pub frequency_hz: f64,
    /// Gain from the command to the angle, dB.
    pub gain_db: f64,
    /// Phase, within half a turn of zero, deg; the transport delay is included.
    pub phase_deg: f64,
}

/// The sine with which one frequency is measured: a whole number of periods in a whole number of
/// control periods.
#[derive(Debug, Clone, Copy)]
pub(super) struct Command {
    periods: u32,
    pub ticks: u64,
    amplitude_deg: f64,
}

impl Command {
    pub fn of(model: &Model, frequency_hz: f64) -> Self {
        let periods = (SHORTEST_S * frequency_hz).ceil();
        let control_periods = (periods / frequency_hz * f64::from(CONTROL_RATE_HZ)).round();
        Self {
            periods: periods as u32,
            ticks: control_periods as u64 * CONTROL_PERIOD_TICKS,
            amplitude_deg: model.sweep_amplitude_deg,
        }
    }

    /// The command at a tick, deg.
    pub fn at(&self, tick: u64) -> f64 {
        let turns = f64::from(self.periods) * tick as f64 / self.ticks as f64;
        self.amplitude_deg * (TAU * turns).sin()
    }
}

/// Measures at one frequency: the actuator settles for as long as it is measured then.
///
/// # Errors
/// Those of [`crate::scenario::Scenario::settings`].
pub fn measure(model: &Model, frequency_hz: f64) -> Result<Point, Error> {
    let mut actuator = Actuator::try_new(&model.scenario("sine").settings()?)?;
    let command = Command::of(model, frequency_hz);
    let mut angles_deg = Vec::new();
    for tick in 0..2 * command.ticks {
        if tick >= command.ticks && tick.is_multiple_of(CONTROL_PERIOD_TICKS) {
            angles_deg.push(actuator.reading().angle_deg);
        }
        // A sine is a finite command.
        let _ = actuator.advance(command.at(tick), 1);
    }
    let (amplitude_deg, phase_deg) = sine(&angles_deg, command.periods);
    Ok(Point {
        frequency_hz: f64::from(command.periods) / seconds(command.ticks),
        gain_db: decibel(amplitude_deg / command.amplitude_deg),
        phase_deg,
    })
}

/// The frequency at which the measured power falls to a half, Hz, by the false-position method
/// between the two enclosing points.
///
/// # Errors
/// Those of [`measure`].
pub fn bandwidth_hz(model: &Model, points: &[Point]) -> Result<Option<f64>, Error> {
    let mut points = points.to_vec();
    for _ in 0..REFINEMENTS {
        let Some(crossing_hz) = half_power_hz(&points) else {
            return Ok(None);
        };
        let point = measure(model, crossing_hz)?;
        let place = points.partition_point(|p| p.frequency_hz < point.frequency_hz);
        points.insert(place, point);
    }
    Ok(half_power_hz(&points))
}

/// The first frequency at which the gain falls to half the power, Hz, on a straight line between
/// the two enclosing points.
fn half_power_hz(points: &[Point]) -> Option<f64> {
    let mut pairs = points.iter().zip(points.iter().skip(1));
    pairs.find_map(|(low, high)| {
        let share = (low.gain_db - HALF_POWER_DB) / (low.gain_db - high.gain_db);
        let falls = low.gain_db > HALF_POWER_DB && high.gain_db <= HALF_POWER_DB;
        falls.then_some(low.frequency_hz + share * (high.frequency_hz - low.frequency_hz))
    })
}
