//! The measured angle of a motion against that of a model.

use super::PERIOD_S;
use crate::plot::{Figure, Panel, Series, Style};

/// Angles in each control period, deg.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Comparison {
    /// The command.
    pub command_deg: Vec<f64>,
    /// The measured angle.
    pub measured_deg: Vec<f64>,
    /// That of the model.
    pub predicted_deg: Vec<f64>,
}

impl Comparison {
    /// The angles, and their difference.
    pub(super) fn figure(&self, title: &str) -> Figure {
        let time_s: Vec<f64> = (0..self.measured_deg.len())
            .map(|period| period as f64 * PERIOD_S)
            .collect();
        let pairs = self.measured_deg.iter().zip(&self.predicted_deg);
        let difference: Vec<f64> = pairs
            .map(|(measured, predicted)| measured - predicted)
            .collect();
        let angles = Panel::new("angle (deg)")
            .series(Series::new("command", 0, &time_s, &self.command_deg).style(Style::Step))
            .series(Series::new("predicted", 2, &time_s, &self.predicted_deg))
            .series(Series::new("measured", 1, &time_s, &self.measured_deg));
        let difference = Panel::new("measured less predicted (deg)").series(Series::new(
            "difference",
            1,
            &time_s,
            &difference,
        ));
        Figure::new(title, "time (s)")
            .panel(angles)
            .panel(difference)
    }
}
