//! The figure of a trace.

use super::{Colours, Figure, Panel, Series, Style};
use crate::trace::Trace;

/// The panels: the label of the axis and the columns.
const PANELS: [(&str, &[&str]); 4] = [
    ("angle (deg)", &["command", "angle_deg", "angle_meas_deg"]),
    ("rate (deg/s)", &["rate_deg_s", "rate_meas_deg_s"]),
    ("duty (%)", &["duty_pct"]),
    ("current (A)", &["current_a"]),
];

/// The figure of a trace: command and angle, rate, duty and, if recorded, current over time.
pub fn of_trace(title: &str, trace: &Trace) -> Figure {
    let t = trace.column("t").unwrap_or_default();
    let mut colours = Colours::default();
    let mut figure = Figure::new(title, "time (s)");
    for (label, names) in PANELS {
        let columns = names
            .iter()
            .filter_map(|name| Some((*name, trace.column(name)?)));
        let mut panel = Panel::new(label);
        for (name, column) in columns.filter(|(name, c)| is_shown(name, c)) {
            let style = if name == "command" {
                Style::Step
            } else {
                Style::Line
            };
            panel = panel.series(Series::new(name, colours.of(name), t, column).style(style));
        }
        if !panel.series.is_empty() {
            figure = figure.panel(panel);
        }
    }
    figure
}

/// A model without a duty records a column of zeros, which is not drawn.
fn is_shown(name: &str, column: &[f64]) -> bool {
    name != "duty_pct" || column.iter().any(|value| *value != 0.0)
}
