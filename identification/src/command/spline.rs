//! Cubic splines through ranges of samples.
//!
//! A range is divided where its slope jumps, as at the corner of a ramp. Within a piece the spline
//! has two continuous derivatives (de Boor, A Practical Guide to Splines, chapter IV); its end
//! slopes are those of the cubic through the four outermost samples.

use super::Segment;

/// Appends the curve through at least two samples.
pub fn append(segments: &mut Vec<Segment>, time_ns: &[i64], values: &[f64]) {
    let mut from = 0;
    for corner in corners(values).into_iter().chain([values.len() - 1]) {
        piece(segments, &time_ns[from..=corner], &values[from..=corner]);
        from = corner;
    }
}

/// The inner samples at which the slope jumps.
fn corners(values: &[f64]) -> Vec<usize> {
    let bend = |i: usize| values[i + 1] - 2.0 * values[i] + values[i - 1];
    let inner = 1..values.len() - 1;
    let size = |i: usize| {
        if inner.contains(&i) {
            bend(i).abs()
        } else {
            0.0
        }
    };
    let scale = values
        .windows(2)
        .fold(0.0_f64, |m, p| m.max((p[1] - p[0]).abs()));
    let is_corner = |i: &usize| {
        // Rounding is ignored; on a smooth curve the neighbours have a curvature as well.
        size(*i) > 1e-6 * scale && size(i - 1).max(size(i + 1)) < size(*i) / 8.0
    };
    inner.clone().filter(is_corner).collect()
}

fn piece(segments: &mut Vec<Segment>, time_ns: &[i64], values: &[f64]) {
    let widths: Vec<f64> = time_ns
        .windows(2)
        .map(|t| (t[1] - t[0]) as f64 * 1e-9)
        .collect();
    let secants: Vec<f64> = values
        .windows(2)
        .zip(&widths)
        .map(|(v, h)| (v[1] - v[0]) / h)
        .collect();
    let slopes = slopes(&widths, &secants);
    for (i, (h, secant)) in widths.iter().zip(&secants).enumerate() {
        let (left, right) = (slopes[i], slopes[i + 1]);
        segments.push(Segment {
            start_ns: time_ns[i],
            q: [
                values[i],
                left,
                (3.0 * secant - 2.0 * left - right) / h,
                (left + right - 2.0 * secant) / (h * h),
            ],
            is_constant: false,
            jumps: false,
            variable: None,
        });
    }
}

/// The slopes at the samples: second derivatives agree at the inner ones.
fn slopes(widths: &[f64], secants: &[f64]) -> Vec<f64> {
    let n = secants.len();
    if n == 1 {
        return vec![secants[0]; 2];
    }
    let first = end_slope(widths.iter().zip(secants));
    let last = end_slope(widths.iter().zip(secants).rev());
    let mut slopes = vec![first; n + 1];
    // Thomas' algorithm on h_i m_{i-1} + 2 (h_{i-1} + h_i) m_i + h_{i-1} m_{i+1} = rhs.
    let mut ratios = vec![0.0; n + 1];
    for i in 1..n {
        let (before, after) = (widths[i - 1], widths[i]);
        let right = 3.0 * (after * secants[i - 1] + before * secants[i]);
        let pivot = 2.0 * (before + after) - after * ratios[i - 1];
        ratios[i] = before / pivot;
        slopes[i] = (right - after * slopes[i - 1]) / pivot;
    }
    slopes[n] = last;
    for i in (1..n).rev() {
        slopes[i] -= ratios[i] * slopes[i + 1];
    }
    slopes
}

/// Slope at its end of the polynomial through up to four samples, in Newton's form from the end:
/// intervals with their secants, the outermost first.
fn end_slope<'a>(intervals: impl Iterator<Item = (&'a f64, &'a f64)>) -> f64 {
    let (mut slope, mut distance, mut product) = (0.0, 0.0, 1.0);
    // Divided differences that end at the last sample taken, lowest order first.
    let mut differences: Vec<f64> = Vec::with_capacity(3);
    let mut distances: Vec<f64> = vec![0.0];
    for (width, secant) in intervals.take(3) {
        distance += width;
        let mut next = vec![*secant];
        for (order, before) in differences.iter().enumerate() {
            let from = distances[distances.len() - 2 - order];
            next.push((next[order] - before) / (distance - from));
        }
        // d/dt of (t - t0)(t - t1)... at t0 is the product of (t0 - t1)...
        slope += next[next.len() - 1] * product;
        product *= -distance;
        differences = next;
        distances.push(distance);
    }
    slope
}
