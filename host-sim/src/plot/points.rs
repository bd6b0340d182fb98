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
pub fn straightened(points: &[Point], x_scale: Scale, tolerance: f64) -> Vec<Point> {
    let place = |(x, _): &Point| match x_scale {
        Scale::Linear => *x,
        Scale::Log => x.log10(),
    };
    let x: Vec<f64> = points.iter().map(place).collect();
    let y: Vec<f64> = points.iter().map(|point| point.1).collect();
    let kept = straight(&x, &[&y], tolerance);
    kept.into_iter().map(|index| points[index]).collect()
}

/// The indices of samples between which every column is straight to within `tolerance`; jumps and
/// ends are kept. Samples beyond the end of the shortest column are ignored.
///
/// This is swinging-door compression (E. H. Bristol, "Swinging door trending: adaptive trend
/// recording?", ISA 1990) with one door for each column.
pub fn straight(x: &[f64], columns: &[&[f64]], tolerance: f64) -> Vec<usize> {
    let lengths = columns.iter().map(|column| column.len());
    let len = lengths.fold(x.len(), usize::min);
    let mut kept: Vec<usize> = (0..len.min(1)).collect();
    let open = || vec![(f64::NEG_INFINITY, f64::INFINITY); columns.len()];
    let (mut doors, mut from) = (open(), 0);
    for i in 1..len {
        let slope = |column: &[f64], from: usize, off: f64| {
            (column[i] + off - column[from]) / (x[i] - x[from])
        };
        // The slope of a jump is infinite or NaN, and passes no door.
        let passes = |(column, door): (&&[f64], &(f64, f64))| {
            let slope = slope(column, from, 0.0);
            door.0 <= slope && slope <= door.1 && slope.is_finite()
        };
        if !columns.iter().zip(&doors).all(passes) {
            if from + 1 < i {
                kept.push(i - 1);
            }
            (from, doors) = (i - 1, open());
        }
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

    proptest! {
        #[test]
        fn omitted_samples_lie_on_the_line_to_within_the_tolerance(
            ys in prop::collection::vec((-90.0..90.0f64, -90.0..90.0f64), 0..200),
            tolerance in 0.1..50.0f64,
        ) {
            let (a, b): (Vec<_>, Vec<_>) = ys.into_iter().unzip();
            let t: Vec<f64> = (0..a.len()).map(|i| i as f64 * 1e-3).collect();
            let kept = straight(&t, &[&a, &b], tolerance);
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
