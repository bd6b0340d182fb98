//! The figure of a trace.

use super::{Figure, Panel, Series, Style};
use crate::trace::Trace;

/// The panels: the label of the axis, and the columns with their colours in the order in which they
/// are drawn. A measured quantity, a band as wide as its quantisation, is drawn below the true one.
const PANELS: [(&str, &[(&str, usize)]); 4] = [
    (
        "angle (deg)",
        &[("command_deg", 0), ("angle_meas_deg", 6), ("angle_deg", 1)],
    ),
    ("rate (deg/s)", &[("rate_meas_deg_s", 5), ("rate_deg_s", 2)]),
    ("duty (%)", &[("duty_pct", 3)]),
    ("current (A)", &[("current_a", 4)]),
];

/// The figure of a trace: command and angle, rate, duty and, if recorded, current over time.
pub fn of_trace(title: &str, trace: &Trace) -> Figure {
    let t = trace.column("time_s").unwrap_or_default();
    let mut figure = Figure::new(title, "time (s)");
    for (label, names) in PANELS {
        let columns = names
            .iter()
            .filter_map(|(name, colour)| Some((*name, *colour, trace.column(name)?)));
        let mut panel = Panel::new(label);
        for (name, colour, column) in columns.filter(|(name, _, c)| is_shown(name, c)) {
            let style = if name == "command_deg" {
                Style::Step
            } else {
                Style::Line
            };
            panel = panel.series(Series::new(name, colour, t, column).style(style));
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
