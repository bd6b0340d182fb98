//! Bode plots: computed lines and measured points.

use super::{comparison::Outcome, models::Model, sweep::Point};
use crate::{
    analysis::frequency::{HALF_POWER_DB, Response, logarithmic_grid, unwrap_deg},
    plot::{Figure, Panel, Series, Style},
};

/// The axis begins where all models have a gain of one and ends above the last measurement.
const FROM_HZ: f64 = 0.1;
const TO_HZ: f64 = 30.0;
const POINTS_PER_DECADE: usize = 60;

/// The responses of these models without their transport delay, as in the paper's figure 11.
pub fn figure(title: &str, outcomes: &[&Outcome]) -> Figure {
    let grid = logarithmic_grid(FROM_HZ, TO_HZ, POINTS_PER_DECADE);
    let level = Series::new("half power", 0, &[FROM_HZ, TO_HZ], &[HALF_POWER_DB; 2]);
    let mut gain = Panel::new("gain (dB)")
        .y_step(10.0)
        .series(level.style(Style::Dashed));
    let mut phase = Panel::new("phase without delay (deg)").y_step(45.0);
    let lines = outcomes.iter().filter_map(|o| {
        let computed = Response::of(&o.linear.as_ref()?.closed, &grid);
        Some((
            o,
            o.runs.model.name.to_owned(),
            computed,
            o.runs.model.style,
        ))
    });
    let points = outcomes.iter().map(|o| {
        let label = format!("{}, measured", o.runs.model.name);
        (
            o,
            label,
            undelayed(&o.runs.response, o.runs.settings.setup.delay_s),
            Style::Points,
        )
    });
    for (outcome, label, response, style) in lines.chain(points) {
        let Model { colour, .. } = outcome.runs.model;
        let series =
            |y: &[f64]| Series::new(&label, colour, &response.frequency_hz, y).style(style);
        gain = gain.series(series(&response.gain_db));
        phase = phase.series(series(&response.phase_deg));
    }
    Figure::new(title, "frequency (Hz)")
        .log_x()
        .panel(gain)
        .panel(phase)
}

/// A measured response without the transport delay.
pub fn undelayed(points: &[Point], delay_s: f64) -> Response {
    let phase_deg = |point: &Point| point.phase_deg + 360.0 * point.frequency_hz * delay_s;
    let mut phase_deg: Vec<f64> = points.iter().map(phase_deg).collect();
    unwrap_deg(&mut phase_deg);
    Response {
        frequency_hz: points.iter().map(|point| point.frequency_hz).collect(),
        gain_db: points.iter().map(|point| point.gain_db).collect(),
        phase_deg,
    }
}
