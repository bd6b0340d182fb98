//! Panels of curves over one time axis, without samples that make no visible difference.
//!
//! The curves of a panel keep the same instants, so that a cursor can show all of them. Between two
//! instants every curve is straight to within a fraction of the panel's range. The instants are
//! chosen by swinging-door compression (E. H. Bristol, "Swinging door trending: adaptive trend
//! recording?", ISA 1990) with one door for each curve.

use super::models::Model;
use crate::plot::{Panel, Series, Style, points::range};

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
    let mut kept = thin(t, &columns, tolerance);
    while kept.len() > MOST && tolerance.is_finite() {
        tolerance *= 1.4;
        kept = thin(t, &columns, tolerance);
    }
    let pick = |column: &[f64]| kept.iter().map(|i| column[*i]).collect::<Vec<_>>();
    let x = pick(t);
    curves.iter().fold(Panel::new(y_label), |panel, curve| {
        let series = Series::new(&curve.label, curve.colour, &x, &pick(&curve.y));
        panel.series(series.style(curve.style))
    })
}

/// The indices of the samples to keep. Samples beyond the end of the shortest column are ignored.
fn thin(t: &[f64], columns: &[&[f64]], tolerance: f64) -> Vec<usize> {
    let lengths = columns.iter().map(|column| column.len());
    let len = lengths.fold(t.len(), usize::min);
    let mut kept: Vec<usize> = (0..len.min(1)).collect();
    let open = || vec![(f64::NEG_INFINITY, f64::INFINITY); columns.len()];
    let mut doors = open();
    for i in 1..len {
        let anchor = kept[kept.len() - 1];
        let slope = |column: &[f64], from: usize, off: f64| {
            (column[i] + off - column[from]) / (t[i] - t[from])
        };
        let passes = |(column, door): (&&[f64], &(f64, f64))| {
            let slope = slope(column, anchor, 0.0);
            door.0 <= slope && slope <= door.1
        };
        let from = if columns.iter().zip(&doors).all(passes) {
            anchor
        } else {
            kept.push(i - 1);
            doors = open();
            i - 1
        };
        for (door, column) in doors.iter_mut().zip(columns) {
            door.0 = door.0.max(slope(column, from, -tolerance));
            door.1 = door.1.min(slope(column, from, tolerance));
        }
    }
    if len > 1 {
        kept.push(len - 1);
    }
    kept
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn times(len: usize) -> Vec<f64> {
        (0..len).map(|i| i as f64 * 1e-3).collect()
    }

    proptest! {
        #[test]
        fn omitted_samples_lie_on_the_line_to_within_the_tolerance(
            ys in prop::collection::vec((-90.0..90.0f64, -90.0..90.0f64), 0..200),
            tolerance in 0.1..50.0f64,
        ) {
            let (a, b): (Vec<_>, Vec<_>) = ys.into_iter().unzip();
            let t = times(a.len());
            let kept = thin(&t, &[&a, &b], tolerance);
            prop_assert!(kept.is_sorted());
            prop_assert_eq!(kept.first().copied(), (!a.is_empty()).then_some(0));
            prop_assert_eq!(kept.last().copied(), a.len().checked_sub(1));
            for ends in kept.windows(2) {
                for column in [&a, &b] {
                    for i in ends[0]..ends[1] {
                        let share = (t[i] - t[ends[0]]) / (t[ends[1]] - t[ends[0]]);
                        let line = column[ends[0]] + share * (column[ends[1]] - column[ends[0]]);
                        // Rounding of slopes of up to 2e5 over 0.2 s.
                        prop_assert!((column[i] - line).abs() <= tolerance + 1e-9);
                    }
                }
            }
        }
    }

    #[test]
    fn both_samples_of_a_step_are_kept() {
        let t = times(1000);
        let y: Vec<f64> = (0..1000)
            .map(|i| if i < 400 { 0.0 } else { 90.0 })
            .collect();
        assert_eq!(thin(&t, &[&y], 0.1), [0, 399, 400, 999]);
    }

    #[test]
    fn a_panel_has_one_time_axis_of_bounded_length_for_any_curves() {
        let t = times(20_000);
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
