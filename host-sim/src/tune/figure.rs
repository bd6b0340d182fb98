//! The Bode plot of a tuned loop.

use super::{TuneError, TuneRequest, Tuning};
use crate::{
    analysis::{
        frequency::{Response, logarithmic_grid},
        linear_models::Loop,
        loop_gain::Margins,
    },
    plot::{Colours, Figure, Panel, Series, Style},
};

const POINTS_PER_DECADE: usize = 100;

/// Open and closed loop on the board, with the margins as vertical lines.
///
/// # Errors
/// [`TuneError::Parameter`] for a parameter that is out of range.
pub fn bode(request: &TuneRequest, tuning: &Tuning) -> Result<Figure, TuneError> {
    let servo = Loop::sampled(&request.motor, &tuning.control, &request.timing)?;
    let nyquist_hz = 0.5 / request.timing.control_period_s;
    // From well below the lowest crossing to the Nyquist frequency of the loop.
    let margins = stable_margins(tuning);
    let crossings = [margins.phase_deg, margins.gain_db];
    let slowest_hz = crossings.into_iter().flatten().map(|m| m.frequency_hz);
    let from_hz = 0.05 * slowest_hz.fold(0.1 * nyquist_hz, f64::min);
    let grid = logarithmic_grid(from_hz, 0.999 * nyquist_hz, POINTS_PER_DECADE);
    let mut colours = Colours::default();
    let (mut gain, mut phase) = (Panel::new("gain (dB)"), Panel::new("phase (deg)"));
    for (name, system) in [("open loop", &servo.open), ("closed loop", &servo.closed)] {
        let response = Response::of(system, &grid);
        let (x, colour) = (&response.frequency_hz, colours.of(name));
        gain = gain.series(Series::new(name, colour, x, &response.gain_db));
        phase = phase.series(Series::new(name, colour, x, &response.phase_deg));
    }
    let mut mark = |name: &str, hz: f64, ends: [f64; 2]| {
        Series::new(name, colours.of(name), &[hz, hz], &ends).style(Style::Dashed)
    };
    if let Some(margin) = margins.gain_db {
        gain = gain.series(mark(
            "gain margin",
            margin.frequency_hz,
            [-margin.value, 0.0],
        ));
    }
    if let Some(margin) = margins.phase_deg {
        let ends = [-180.0, margin.value - 180.0];
        phase = phase.series(mark("phase margin", margin.frequency_hz, ends));
    }
    let figure = Figure::new("The tuned loop on the board", "frequency (Hz)").log_x();
    let figure = figure.panel(gain).panel(phase.y_step(45.0));
    let warnings = tuning.warnings.iter();
    Ok(warnings.fold(figure, |figure, warning| {
        figure.warning(warning.to_string())
    }))
}

/// The margins; empty for an unstable loop, whose margins have no meaning.
pub fn stable_margins(tuning: &Tuning) -> Margins {
    match tuning.margins {
        margins if margins.stable => margins,
        margins => Margins {
            gain_db: None,
            phase_deg: None,
            delay_s: None,
            ..margins
        },
    }
}
