//! Panels of curves over one time axis, without samples that make no visible difference.
//!
//! The curves of a panel keep the same instants, so that a cursor can show all of them. Between two
//! instants every curve is straight to within a fraction of the panel's range.

use super::models::Model;
use crate::plot::{
    Panel, Series, Style,
    points::{range, straight},
};

/// Resolution of a panel of 200 px that is magnified five times, as a fraction of its range.
const TOLERANCE: f64 = 1e-3;
/// Maximum number of instants of a panel, three per pixel. The tolerance is increased until they
/// suffice, which a fast chirp of 20 s requires.
const MOST: usize = 2000;

/// A curve on the time axis of its panel.
pub struct Curve {
    label: String,
    colour: usize,
    style: Style,
    y: Vec<f64>,
}

impl Curve {
    /// The command.
    pub fn command(y: &[f64]) -> Self {
        Self {
            label: "command".into(),
            colour: 0,
            style: Style::Line,
            y: y.to_vec(),
        }
    }

    /// Makes the line solid.
    pub fn undash(&mut self) {
        self.style = Style::Line;
    }

    /// A quantity of a model, with the colour and line style of the model.
    pub fn of(model: &Model, y: impl Into<Vec<f64>>) -> Self {
        Self {
            label: model.name.into(),
            colour: model.colour,
            style: model.style,
            y: y.into(),
        }
    }
}

/// A panel of curves that are all sampled at the times `t`.
pub fn panel(y_label: &str, t: &[f64], curves: &[Curve]) -> Panel {
    let all = || curves.iter().flat_map(|curve| curve.y.iter().copied());
    let (low, high) = range(all()).unwrap_or((0.0, 1.0));
    let columns: Vec<&[f64]> = curves.iter().map(|curve| curve.y.as_slice()).collect();
    let mut tolerance = TOLERANCE * (high - low);
    let mut kept = straight(t, &columns, tolerance);
    while kept.len() > MOST && tolerance.is_finite() {
        tolerance *= 1.4;
        kept = straight(t, &columns, tolerance);
    }
    let pick = |column: &[f64]| kept.iter().map(|i| column[*i]).collect::<Vec<_>>();
    let x = pick(t);
    curves.iter().fold(Panel::new(y_label), |panel, curve| {
        let series = Series::new(&curve.label, curve.colour, &x, &pick(&curve.y));
        panel.series(series.style(curve.style))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panel_has_one_time_axis_of_bounded_length_for_any_curves() {
        let t: Vec<f64> = (0..20_000).map(f64::from).collect();
        let noise = |k: u64| -> Vec<f64> {
            (0..20_000_u64)
                .map(|i| (i.wrapping_mul(i + k) % 97) as f64)
                .collect()
        };
        let panel = panel(
            "angle (deg)",
            &t,
            &[Curve::command(&noise(3)), Curve::command(&noise(8))],
        );
        assert!(panel.series[0].x.len() <= MOST);
        assert_eq!(panel.series[0].x, panel.series[1].x);
    }
}
