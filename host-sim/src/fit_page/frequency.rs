//! The frequency response with its confidence interval, and low-order equivalent systems.

use super::{Content, tables};
use identification::frequency::{
    Equivalent, FrequencyResponse,
    equivalent::{ACCEPTABLE_COST, LEAST_COHERENCE},
};

use crate::{
    analysis::frequency::{decibel, unwrap_deg},
    page::{Block, Section},
    plot::{Figure, Panel, Series, Style},
};

const TEXT: &str = "An independent analysis without simulation: the frequency response of the recordings \
    by Welch's method, and the low-order systems that are closest to it. Rate-limited recordings give \
    the describing function for their amplitude, which is slower than the actuator for small signals.";

/// Makes the section.
pub fn section(content: &Content<'_>) -> Section {
    let opinion = content.nonparametric;
    let response = match &opinion.response {
        None => Block::Note(
            "The recordings are too short or have too little motion for a frequency response."
                .into(),
        ),
        Some(response) => {
            let systems = [
                ("first order", opinion.first_order.as_ref()),
                ("second order", opinion.second_order.as_ref()),
            ];
            figure(response, &systems).into()
        }
    };
    let systems = tables::equivalents(opinion);
    let systems = match systems.rows.is_empty() {
        true => Block::Note("Too few points are coherent for an equivalent system.".into()),
        false => systems.into(),
    };
    let blocks = [
        TEXT.into(),
        response,
        systems,
        tables::delays(opinion).into(),
    ];
    Section::new("Frequency response", blocks)
}

fn figure(response: &FrequencyResponse, systems: &[(&str, Option<&Equivalent>)]) -> Figure {
    let f = &response.frequency_hz;
    // Points without coherence are noise and would determine the scale.
    let shown = |y: &[f64]| {
        let values = y.iter().zip(&response.coherence);
        let value = |(y, c): (&f64, &f64)| if *c >= LEAST_COHERENCE { *y } else { f64::NAN };
        values.map(value).collect::<Vec<f64>>()
    };
    let banded = |panel: Panel, y: &[f64], error: &[f64]| {
        let edge = |sign: f64| {
            let edge: Vec<f64> = y.iter().zip(error).map(|(y, e)| y + sign * e).collect();
            Series::new("95 % interval", 7, f, &shown(&edge)).style(Style::Dashed)
        };
        let measured = Series::new("recordings", 1, f, &shown(y)).style(Style::Points);
        panel.series(edge(1.0)).series(edge(-1.0)).series(measured)
    };
    let gain = Panel::new("gain (dB)");
    let phase = Panel::new("phase (deg)").y_step(90.0);
    let mut gain = banded(gain, &response.gain_db, &response.gain_error_db);
    let mut phase = banded(phase, &response.phase_deg, &response.phase_error_deg);
    for (index, (name, system)) in systems.iter().enumerate() {
        let Some(system) = system else { continue };
        let range = |f: &&f64| **f >= system.from_hz && **f <= system.to_hz;
        let at: Vec<f64> = f.iter().filter(range).copied().collect();
        let values: Vec<_> = at.iter().map(|f| system.at(*f)).collect();
        let gains: Vec<f64> = values.iter().map(|v| decibel(v.norm())).collect();
        let mut phases: Vec<f64> = values.iter().map(|v| v.arg().to_degrees()).collect();
        unwrap_deg(&mut phases);
        let acceptable = system.cost <= ACCEPTABLE_COST;
        let label = format!("{name}{}", if acceptable { "" } else { " (poor)" });
        gain = gain.series(Series::new(label.clone(), 2 + index, &at, &gains));
        phase = phase.series(Series::new(label, 2 + index, &at, &phases));
    }
    let coherence =
        Panel::new("coherence").series(Series::new("coherence", 3, f, &response.coherence));
    Figure::new("Bode plot of the recordings", "frequency (Hz)")
        .log_x()
        .panel(gain)
        .panel(phase)
        .panel(coherence)
        .caption(format!(
            "Mean of {:.1} independent windows; points with a coherence below {LEAST_COHERENCE} are \
             not shown.",
            response.averages
        ))
}
