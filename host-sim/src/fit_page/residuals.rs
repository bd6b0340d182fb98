//! Correlations of the residuals with themselves and with the command, in their bands.

use crate::{
    page::Section,
    plot::{Figure, Panel, Series, Style},
};
use identification::{
    assessment::{Assessed, Assessment},
    statistics::Correlations,
};

/// A figure for each model and recording.
pub fn section(assessments: &[Assessment]) -> Section {
    let section = Section::new("Residuals").text(
        "Within the dashed bands chance alone keeps 95 % of the points. Points of the upper panel \
         beyond them mean coloured residuals: the standard errors for white ones are too small \
         then. Points of the lower panel beyond them at positive lags mean that the actuator does \
         something with the command that the model does not.",
    );
    let all = assessments.iter().flat_map(|a| {
        let name = a.name.as_str();
        a.experiments.iter().filter_map(move |e| figure(name, e))
    });
    section.gallery(all.collect::<Vec<_>>())
}

fn figure(model: &str, assessed: &Assessed) -> Option<Figure> {
    let c: &Correlations = assessed.correlations.as_ref()?;
    let title = format!("Residuals of {model} on {}", assessed.recording.name);
    let auto = banded("autocorrelation", &c.auto_lag_s, &c.auto, &c.auto_band);
    let cross = banded(
        "with the command's changes",
        &c.cross_lag_s,
        &c.cross,
        &c.cross_band,
    );
    let caption = format!(
        "White: {} (p = {:.3}). Free of the command: {}.",
        yes(c.whiteness.is_white()),
        c.whiteness.p_value,
        yes(!c.is_correlated_with_input()),
    );
    let figure = Figure::new(title, "lag (s)").panel(auto).panel(cross);
    Some(figure.caption(caption))
}

fn yes(is_it: bool) -> &'static str {
    if is_it { "yes" } else { "no" }
}

fn banded(label: &str, lag_s: &[f64], value: &[f64], band: &[f64]) -> Panel {
    let lower: Vec<f64> = band.iter().map(|b| -b).collect();
    let edge = |y: &[f64]| Series::new("95 % band", 7, lag_s, y).style(Style::Dashed);
    Panel::new(label)
        .series(edge(band))
        .series(edge(&lower))
        .series(Series::new(label, 1, lag_s, value))
}
