//! The measured frequency response: the simulator is driven by one sine after the other.

use super::models::Model;
use crate::{
    analysis::{
        frequency::{HALF_POWER_DB, Response, unwrap_deg},
        sine_fit::fit,
    },
    error::Error,
    scenario::Setting,
    trace::Trace,
};
use model_core::time::CONTROL_PERIOD_TICKS;

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

/// Settling time, s: 20 time constants of the slowest closed-loop pole, 7 1/s.
const SETTLING_S: f64 = 3.0;
/// Minimum measuring time, s ...
const SHORTEST_S: f64 = 4.0;
/// ... and minimum number of periods: the encoder's rounding differs between them.
const FEWEST_PERIODS: f64 = 3.0;
/// Iterations of the search for the bandwidth. The gain is almost a straight line between two
/// frequencies: each iteration reduces the error to less than a tenth.
const REFINEMENTS: usize = 3;

/// Gain, dB, and phase within half a turn, deg, from command to angle, transport delay included.
pub type Point = (f64, f64);

/// Measures one frequency. The result is NaN if no sine can be fitted.
///
/// # Errors
/// Those of [`crate::scenario::Scenario::resolve`].
pub fn measure(model: &Model, frequency_hz: f64) -> Result<Point, Error> {
    let trace = trace(model, frequency_hz)?;
    let t = trace.column("t").unwrap_or_default();
    let settled = t.partition_point(|t| *t < SETTLING_S);
    let sine = |name| {
        let column = trace.column(name).unwrap_or_default();
        fit(&t[settled..], &column[settled..], frequency_hz)
    };
    let point = sine("angle_deg").zip(sine("command"));
    Ok(point.map_or((f64::NAN, f64::NAN), |(angle, command)| {
        angle.over(&command)
    }))
}

/// The trace of the sine at one frequency, including the transient.
pub(super) fn trace(model: &Model, frequency_hz: f64) -> Result<Trace, Error> {
    let mut scenario = model.scenario("sine");
    scenario.set = [
        Setting::new("input.frequency_hz", frequency_hz),
        Setting::new("input.amplitude_deg", model.sweep_amplitude_deg),
    ]
    .into();
    scenario.duration_s = Some(SETTLING_S + SHORTEST_S.max(FEWEST_PERIODS / frequency_hz));
    // At the control steps: the linear model of the board describes the angle at these instants.
    scenario.every = Some(CONTROL_PERIOD_TICKS);
    scenario.resolve()?.record()
}

/// The response from measurements at [`FREQUENCIES_HZ`].
pub fn response(points: &[Point]) -> Response {
    let mut phase_deg: Vec<_> = points.iter().map(|point| point.1).collect();
    unwrap_deg(&mut phase_deg);
    Response {
        frequency_hz: FREQUENCIES_HZ[..points.len()].to_vec(),
        gain_db: points.iter().map(|point| point.0).collect(),
        phase_deg,
    }
}

/// The frequency at which the measured power falls to a half, Hz, by the false-position method
/// between the two enclosing frequencies of the response.
///
/// # Errors
/// Those of [`measure`].
pub fn bandwidth_hz(model: &Model, response: &Response) -> Result<Option<f64>, Error> {
    let above = |gain_db: f64| gain_db > HALF_POWER_DB;
    let gains = response.gain_db.windows(2);
    let Some(i) = gains.clone().position(|g| above(g[0]) && !above(g[1])) else {
        return Ok(None);
    };
    let at = |i: usize| (response.frequency_hz[i].ln(), response.gain_db[i]);
    let (mut low, mut high) = (at(i), at(i + 1));
    let crossing = |a: Point, b: Point| a.0 + (b.0 - a.0) * (HALF_POWER_DB - a.1) / (b.1 - a.1);
    for _ in 0..REFINEMENTS {
        let x = crossing(low, high);
        let (gain_db, _) = measure(model, x.exp())?;
        if above(gain_db) {
            low = (x, gain_db);
        } else {
            high = (x, gain_db);
        }
    }
    Ok(Some(crossing(low, high).exp()).filter(|f| f.is_finite()))
}
