//! Linear least squares.

use super::Estimate;

/// The coefficients of a linear function, and their covariance by the residuals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Regression<const N: usize> {
    /// The coefficients.
    pub coefficients: [f64; N],
    /// Their covariance.
    pub covariance: [[f64; N]; N],
}

impl<const N: usize> Regression<N> {
    /// A coefficient with its standard error.
    pub fn estimate(&self, index: usize) -> Estimate {
        Estimate {
            value: self.coefficients[index],
            standard_error: self.covariance[index][index].sqrt(),
        }
    }
}

/// The function of least squares through rows of factors and a value; `None` for no more rows than
/// coefficients, or for rows that do not determine them.
pub fn regression<const N: usize>(rows: &[([f64; N], f64)]) -> Option<Regression<N>> {
    if rows.len() <= N {
        return None;
    }
    let (mut information, mut products) = ([[0.0; N]; N], [0.0; N]);
    for (factors, value) in rows {
        for i in 0..N {
            products[i] += factors[i] * value;
            for j in 0..N {
                information[i][j] += factors[i] * factors[j];
            }
        }
    }
    let inverse = inverse(information)?;
    let dot = |a: &[f64; N], b: &[f64; N]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let coefficients: [f64; N] = std::array::from_fn(|i| dot(&inverse[i], &products));
    let residuals = rows
        .iter()
        .map(|(factors, value)| value - dot(factors, &coefficients));
    let squares: f64 = residuals.map(|residual| residual * residual).sum();
    let variance = squares / (rows.len() - N) as f64;
    Some(Regression {
        coefficients,
        covariance: inverse.map(|row| row.map(|value| value * variance)),
    })
}

/// Least share of its diagonal that elimination may leave of a regular matrix of numbers with
/// sixteen digits.
const REGULAR: f64 = 1e-12;

/// The inverse of a symmetric positive matrix, by Gauss and Jordan; `None` for a singular one.
fn inverse<const N: usize>(matrix: [[f64; N]; N]) -> Option<[[f64; N]; N]> {
    let mut left = matrix;
    let mut right: [[f64; N]; N] =
        std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }));
    for pivot in 0..N {
        let value = left[pivot][pivot];
        // Not true for NaN either.
        let is_regular = value > matrix[pivot][pivot] * REGULAR;
        if !is_regular {
            return None;
        }
        left[pivot] = left[pivot].map(|entry| entry / value);
        right[pivot] = right[pivot].map(|entry| entry / value);
        for row in (0..N).filter(|row| *row != pivot) {
            let factor = left[row][pivot];
            for column in 0..N {
                left[row][column] -= factor * left[pivot][column];
                right[row][column] -= factor * right[pivot][column];
            }
        }
    }
    Some(right)
}

/// The slope of the line through points; `None` for fewer than three points, or for points at one
/// place.
pub fn slope(points: impl IntoIterator<Item = (f64, f64)>) -> Option<Estimate> {
    let rows: Vec<_> = points.into_iter().map(|(x, y)| ([1.0, x], y)).collect();
    Some(regression(&rows)?.estimate(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_has_its_coefficients_and_their_standard_errors() {
        // y = 2 + 3 x with the residuals 1, -2, 1: a variance of 6 of one degree of freedom.
        let rows = [(0.0, 3.0), (1.0, 3.0), (2.0, 9.0)].map(|(x, y)| ([1.0, x], y));
        let line = regression(&rows).expect("a line");
        for (index, value, variance) in [(0, 2.0, 5.0), (1, 3.0, 3.0)] {
            let found = line.estimate(index);
            assert!((found.value - value).abs() < 1e-12, "{found:?}");
            assert!(
                (found.standard_error - f64::sqrt(variance)).abs() < 1e-12,
                "{found:?}"
            );
        }
    }

    #[test]
    fn points_that_determine_nothing_have_no_line() {
        assert_eq!(slope([(1.0, 1.0), (2.0, 3.0)]), None);
        assert_eq!(slope([(1.0, 1.0), (1.0, 3.0), (1.0, 4.0)]), None);
        let same = [1.0, 2.0, 3.0, 4.0].map(|x| ([1.0, x, 2.0 * x], x));
        assert_eq!(regression(&same), None);
    }
}
