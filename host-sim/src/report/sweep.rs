//! The measured frequency response: the actuator is driven by one sine after the other.

use super::models::Model;
use crate::error::Error;
use model_core::{
    actuator::Actuator,
    evaluation::frequency_response::{Multisine, Point, Sine, half_power_hz},
    time::CONTROL_RATE_HZ,
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
    30.0 / std::f64::consts::TAU,
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

/// Measures at one frequency, whose period is rounded so that a whole number of periods is a whole
/// number of control periods.
///
/// # Errors
/// Those of [`crate::scenario::Scenario::settings`].
pub fn measure(model: &Model, frequency_hz: f64) -> Result<Point, Error> {
    let settings = model.scenario("sine").settings()?;
    let actuator = Actuator::try_new(&settings)?;
    let [point] = command(model, frequency_hz)
        .measure(actuator, settings.setup.delay_s)
        .points;
    Ok(point)
}

/// The sine with which one frequency is measured.
pub(super) fn command(model: &Model, frequency_hz: f64) -> Multisine<1> {
    let periods = (SHORTEST_S * frequency_hz).ceil();
    Multisine {
        control_periods: (periods / frequency_hz * f64::from(CONTROL_RATE_HZ)).round() as u32,
        sines: [Sine {
            multiple: periods as u16,
            amplitude_deg: model.sweep_amplitude_deg,
        }],
    }
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
