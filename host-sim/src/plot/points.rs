//! Reduction of the samples of a series to the points that are drawn.
//!
//! Of the samples in one column of pixels the first, the last, the smallest and the largest are
//! kept, and one gap if there is any. A line through these covers the same pixels as a line through
//! all samples and contains all extremes (M4 aggregation: Jugel, Jerzak, Hackenbroich and Markl,
//! PVLDB 7(10), 2014).

use super::figure::{Scale, Series};

/// Values of a larger magnitude are gaps, so that all differences are finite. No quantity of an
/// actuator is near this limit.
const LARGEST: f64 = 1e30;
/// Smallest value on a logarithmic axis: `kuva` does not draw values below 1e-10.
const SMALLEST_LOG: f64 = 1e-9;

/// A point. NaN in y is a gap, x is finite.
pub type Point = (f64, f64);

/// Whether a value can be drawn on an axis of this scale.
fn drawable(value: f64, scale: Scale) -> bool {
    match scale {
        Scale::Linear => value.abs() <= LARGEST,
        Scale::Log => (SMALLEST_LOG..=LARGEST).contains(&value),
    }
}

/// The points of a series in ascending x, at most five of them for each of `columns` columns.
///
/// A point whose x cannot be drawn (NaN, above 1e30, or not positive on a logarithmic axis) is
/// omitted. A y that cannot be drawn becomes a gap.
pub fn points(series: &Series, x_scale: Scale, columns: usize) -> Vec<Point> {
    let mut all: Vec<Point> = series
        .x
        .iter()
        .zip(&series.y)
        .filter(|(x, _)| drawable(**x, x_scale))
        .map(|(&x, &y)| {
            (
                x,
                if drawable(y, Scale::Linear) {
                    y
                } else {
                    f64::NAN
                },
            )
        })
        .collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    thin(all, columns.max(1))
}

/// Keeps the visible points of each column. All columns have the same number of samples.
fn thin(all: Vec<Point>, columns: usize) -> Vec<Point> {
    let width = all.len().div_ceil(columns);
    // Columns of up to four samples are kept completely.
    if width <= 4 {
        return all;
    }
    let mut kept = Vec::with_capacity(4 * columns);
    for column in all.chunks(width) {
        kept.extend(representatives(column).into_iter().map(|i| column[i]));
    }
    kept
}

/// Leaves out points on a straight line between their neighbours, with an error of at most
/// `tolerance` in y. The points have no gap; jumps and ends are kept.
///
/// From the last kept point the cone of all lines is followed that pass within the tolerance of
/// every point since (Williams, "An efficient algorithm for the piecewise linear approximation of
/// planar curves", CGIP 8(2), 1978).
pub fn straightened(points: &[Point], x_scale: Scale, tolerance: f64) -> Vec<Point> {
    let place = |x: f64| match x_scale {
        Scale::Linear => x,
        Scale::Log => x.log10(),
    };
    let (Some(&first), Some(&last)) = (points.first(), points.last()) else {
        return Vec::new();
    };
    let (mut kept, mut from, mut before) = (vec![first], first, first);
    let mut cone = (f64::NEG_INFINITY, f64::INFINITY);
    for &(x, y) in points.iter().skip(1) {
        let slope = |y: f64, from: Point| (y - from.1) / (place(x) - place(from.0));
        // The slope of a jump is infinite or NaN, and in no cone.
        let direct = slope(y, from);
        if !(direct >= cone.0 && direct <= cone.1 && direct.is_finite()) {
            if before != from {
                kept.push(before);
            }
            from = before;
            cone = (f64::NEG_INFINITY, f64::INFINITY);
        }
        let (low, high) = (slope(y - tolerance, from), slope(y + tolerance, from));
        cone = (cone.0.max(low), cone.1.min(high));
        before = (x, y);
    }
    if last != from || points.len() > 1 {
        kept.push(last);
    }
    kept
}

/// Leaves out points that repeat the value before them, of a curve that holds its value; the last
/// one is kept.
pub fn held(points: &[Point]) -> Vec<Point> {
    let is_last = |index| index + 1 == points.len();
    let repeats = |index: usize| index > 0 && points[index].1 == points[index - 1].1;
    let kept = (0..points.len()).filter(|&index| is_last(index) || !repeats(index));
    kept.map(|index| points[index]).collect()
}

/// The indices of the first, last, smallest and largest sample and of the first gap, ascending.
fn representatives(column: &[Point]) -> Vec<usize> {
    let finite = || (0..column.len()).filter(|&i| !column[i].1.is_nan());
    let by_y = |a: &usize, b: &usize| column[*a].1.total_cmp(&column[*b].1);
    let mut chosen: Vec<usize> = [
        finite().next(),
        finite().next_back(),
        finite().min_by(by_y),
        // The first of equal samples, as for the minimum, so that a step stays at its sample.
        finite().rev().max_by(by_y),
        (0..column.len()).find(|&i| column[i].1.is_nan()),
    ]
    .into_iter()
    .flatten()
    .collect();
    chosen.sort_unstable();
    chosen.dedup();
    chosen
}

/// The smallest and the largest of the values, without gaps.
pub fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.filter(|v| !v.is_nan()).fold(None, |range, v| {
        let (low, high) = range.unwrap_or((v, v));
        Some((
            if v < low { v } else { low },
            if v > high { v } else { high },
        ))
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn linear(y: &[f64], columns: usize) -> Vec<Point> {
        let x: Vec<f64> = (0..y.len()).map(|i| i as f64).collect();
        points(&Series::new("", 0, &x, y), Scale::Linear, columns)
    }

    fn any_value() -> impl Strategy<Value = f64> {
        prop_oneof![8 => -1e3..1e3, 1 => Just(f64::NAN), 1 => any::<f64>()]
    }

    proptest! {
        #[test]
        fn thinning_keeps_extremes_and_ends(
            y in prop::collection::vec(any_value(), 0..2000), columns in 0_usize..50,
        ) {
            let all = linear(&y, usize::MAX);
            let thinned = linear(&y, columns);
            let y_range = |points: &[Point]| range(points.iter().map(|p| p.1));
            prop_assert_eq!(y_range(&all), y_range(&thinned));
            let ends = |points: &[Point]| {
                let mut finite = points.iter().copied().filter(|p| !p.1.is_nan());
                (finite.next(), finite.next_back())
            };
            prop_assert_eq!(ends(&all), ends(&thinned));
            prop_assert!(thinned.len() <= 5 * columns.max(1));
            prop_assert!(thinned.is_sorted_by_key(|p| p.0));
        }
    }

    /// The line through some points at this x.
    fn on_the_line(kept: &[Point], x: f64) -> f64 {
        let after = kept.partition_point(|p| p.0 < x);
        match kept[after].0 == x {
            true => kept[after].1,
            false => {
                let ((x0, y0), (x1, y1)) = (kept[after - 1], kept[after]);
                y0 + (y1 - y0) * (x - x0) / (x1 - x0)
            }
        }
    }

    proptest! {
        #[test]
        fn a_straightened_line_is_within_the_tolerance_of_every_point(
            y in prop::collection::vec(-10.0..10.0, 2..300), tolerance in 0.0..3.0,
        ) {
            let all: Vec<Point> = (0..y.len()).map(|i| (i as f64, y[i])).collect();
            let kept = straightened(&all, Scale::Linear, tolerance);
            prop_assert_eq!((kept[0], kept.last()), (all[0], all.last()));
            for (x, y) in all {
                // And rounding.
                prop_assert!((on_the_line(&kept, x) - y).abs() <= tolerance + 1e-9);
            }
        }
    }

    #[test]
    fn a_straight_line_has_two_points_and_jumps_are_kept() {
        let line: Vec<Point> = (0..100)
            .map(|i| (f64::from(i), f64::from(i) * 0.1))
            .collect();
        assert_eq!(
            straightened(&line, Scale::Linear, 1e-9),
            [line[0], line[99]]
        );
        let jump = [
            (0.0, 1.0),
            (1.0, 1.0),
            (2.0, 1.0),
            (2.0, 5.0),
            (3.0, 5.0),
            (4.0, 5.0),
        ];
        let kept = straightened(&jump, Scale::Linear, 0.01);
        assert_eq!(kept, [(0.0, 1.0), (2.0, 1.0), (2.0, 5.0), (4.0, 5.0)]);
        let steps = [(0.0, 1.0), (1.0, 1.0), (2.0, 3.0), (3.0, 3.0), (4.0, 3.0)];
        assert_eq!(held(&steps), [(0.0, 1.0), (2.0, 3.0), (4.0, 3.0)]);
    }

    #[test]
    fn a_step_stays_at_its_sample() {
        let y: Vec<f64> = (0..1000)
            .map(|i| f64::from((503..707).contains(&i)))
            .collect();
        let thinned = linear(&y, 10);
        let jumps: Vec<f64> = thinned
            .windows(2)
            .filter(|w| w[0].1 != w[1].1)
            .map(|w| w[1].0)
            .collect();
        assert_eq!(jumps, [503.0, 707.0]);
    }

    #[test]
    fn thinning_keeps_a_short_gap() {
        let mut y = vec![1.0; 10_000];
        y[5_003] = f64::NAN;
        let gap = linear(&y, 10).iter().position(|p| p.1.is_nan());
        assert!(gap.is_some_and(|i| i > 0));
    }

    #[test]
    fn a_logarithmic_axis_ignores_values_that_are_not_positive() {
        let series = Series::new(
            "",
            0,
            &[-1.0, 0.0, 1.0, 2.0, 3.0],
            &[1.0, 1.0, 0.0, -1.0, 5.0],
        );
        let points = points(&series, Scale::Log, 100);
        assert_eq!(points, [(1.0, 0.0), (2.0, -1.0), (3.0, 5.0)]);
    }

    #[test]
    fn points_are_sorted_by_x_and_points_of_equal_x_keep_their_order() {
        let series = Series::new("", 0, &[2.0, 1.0, 1.0], &[5.0, 0.0, 4.0]);
        assert_eq!(
            points(&series, Scale::Linear, 100),
            [(1.0, 0.0), (1.0, 4.0), (2.0, 5.0)]
        );
    }
}
