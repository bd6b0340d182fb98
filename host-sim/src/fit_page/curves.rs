//! A recording with the responses of the models and the residuals.

use crate::plot::{Figure, Panel, Series, Style};
use identification::assessment::Assessed;

/// Colour of the measurement. The command has colour 0, the models have the next ones.
const MEASURED: usize = 1;

/// One recording: command, measured angle and every model above, residuals below.
pub fn figure(models: &[(&str, &Assessed)]) -> Figure {
    let Some((_, first)) = models.first() else {
        return Figure::new("", "time (s)");
    };
    let recording = &first.recording;
    let t = &recording.time_s;
    let command = Series::new("command", 0, t, &recording.command_deg).style(Style::Step);
    let measured = Series::new("measured", MEASURED, t, &recording.angle_deg);
    let mut angles = Panel::new("angle (deg)").series(command).series(measured);
    let mut left = Panel::new("residual (deg)");
    for (index, (name, assessed)) in models.iter().enumerate() {
        let series = |y: &[f64]| Series::new(*name, MEASURED + 1 + index, t, y);
        angles = angles.series(series(&assessed.fit.predicted_deg).style(Style::Dashed));
        left = left.series(series(&assessed.fit.residual_deg));
    }
    Figure::new(recording.name.clone(), "time (s)")
        .panel(angles)
        .panel(left)
        .caption(caption(models))
}

/// The fit of each model for this recording, and for how long it was rate limited.
fn caption(models: &[(&str, &Assessed)]) -> String {
    let one = |(name, assessed): &(&str, &Assessed)| {
        let limited_s = assessed.limited.rate_limited_s();
        let limited = match limited_s > 0.0 {
            true => format!(", rate limited for {limited_s:.3} s"),
            false => String::new(),
        };
        format!("{name}: fit {:.2} %{limited}", assessed.fit.fit_percent)
    };
    models.iter().map(one).collect::<Vec<_>>().join("; ") + "."
}
