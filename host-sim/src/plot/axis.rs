//! The limits of an axis.

use super::figure::Scale;

/// Limits that enclose `data` with `margin` (a fraction of the length) on either side and that are
/// distinct even if all data are equal. Without data the limits are 0 to 1, or 1 to 10.
pub fn ends(data: Option<(f64, f64)>, scale: Scale, margin: f64) -> (f64, f64) {
    match (scale, data) {
        (Scale::Linear, None) => (0.0, 1.0),
        (Scale::Log, None) => (1.0, 10.0),
        (Scale::Linear, Some((low, high))) => linear(low, high, margin),
        (Scale::Log, Some((low, high))) => {
            let (low, high) = linear(low.log10(), high.log10(), margin);
            (10_f64.powf(low), 10_f64.powf(high))
        }
    }
}

fn linear(low: f64, high: f64, margin: f64) -> (f64, f64) {
    let length = high - low;
    // With a length below a millionth of the value the tick labels would all be equal.
    let shortest = 1e-6 * low.abs().max(high.abs());
    if length > shortest {
        (low - margin * length, high + margin * length)
    } else {
        let half = if shortest > 0.0 { 1e5 * shortest } else { 0.5 };
        (low - half, high + half)
    }
}

/// Extends the limits to multiples of `step`. `None` if that gives fewer than one or more than
/// twelve intervals.
pub fn by_steps((low, high): (f64, f64), step: f64) -> Option<(f64, f64)> {
    let (first, last) = ((low / step).floor(), (high / step).ceil());
    (1.0..=12.0)
        .contains(&(last - first))
        .then_some((first * step, last * step))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_data_give_distinct_limits() {
        for value in [0.0, 1e-9, -90.0, 1e30] {
            let (low, high) = ends(Some((value, value)), Scale::Linear, 0.0);
            assert!(low < value && value < high, "{value}");
        }
        let (low, high) = ends(Some((2.0, 2.0)), Scale::Log, 0.0);
        assert!(low < 2.0 && 2.0 < high);
        assert_eq!(ends(None, Scale::Linear, 0.1), (0.0, 1.0));
    }

    #[test]
    fn a_margin_on_a_logarithmic_axis_is_a_ratio() {
        let (low, high) = ends(Some((1.0, 100.0)), Scale::Log, 0.5);
        assert!((low - 0.1).abs() < 1e-12 && (high - 1000.0).abs() < 1e-9);
    }

    #[test]
    fn limits_by_steps_are_multiples_of_the_step() {
        assert_eq!(by_steps((-170.0, 3.0), 45.0), Some((-180.0, 45.0)));
        assert_eq!(by_steps((0.0, 1e9), 45.0), None);
        assert_eq!(by_steps((0.0, 1.0), 0.0), None);
        assert_eq!(by_steps((0.0, 1.0), f64::NAN), None);
    }
}
