//! Autocorrelation of the residuals and their cross-correlation with the command.

use crate::{
    page::{Block, Section},
    plot::{Figure, Panel, Series, Style},
};
use identification::{
    assessment::{Assessed, Assessment},
    statistics::Correlations,
};

/// Makes a section with a figure for each model and recording.
pub fn section(assessments: &[Assessment]) -> Section {
    let text = "If the residuals are white and independent of the command, 95 % of the points are within \
         the dashed bands. Points outside in the upper panel mean coloured residuals, for which the \
         standard errors for white residuals are too small. Points outside in the lower panel at \
         positive lags mean that the actuator responds to the command in a way that the model does \
         not describe.";
    let all = assessments.iter().flat_map(|a| {
        let name = a.name.as_str();
        a.experiments.iter().filter_map(move |e| figure(name, e))
    });
    Section::new("Residuals", [text.into(), Block::Figures(all.collect())])
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
        "White: {} (p = {:.3}). Independent of the command: {}.",
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
