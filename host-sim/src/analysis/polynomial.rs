//! Real polynomials and the Hurwitz criterion.

use num_complex::Complex64;
use std::ops::{Add, Mul};

/// A polynomial with real coefficients.
#[derive(Debug, Clone, PartialEq)]
pub struct Polynomial(Vec<f64>);

impl Polynomial {
    /// Creates a polynomial from its coefficients, lowest power first.
    ///
    /// ```
    /// use host_sim::analysis::polynomial::Polynomial;
    /// use num_complex::Complex64;
    /// // 2 + 3 x + x^2 at x = j
    /// let value = Polynomial::new([2.0, 3.0, 1.0]).at(Complex64::I);
    /// assert_eq!(value, Complex64::new(1.0, 3.0));
    /// ```
    pub fn new(coefficients: impl Into<Vec<f64>>) -> Self {
        let mut coefficients = coefficients.into();
        while coefficients.len() > 1 && coefficients.last() == Some(&0.0) {
            coefficients.pop();
        }
        Self(coefficients)
    }

    /// Its value at `x`.
    pub fn at(&self, x: Complex64) -> Complex64 {
        let zero = Complex64::new(0.0, 0.0);
        self.0.iter().rev().fold(zero, |sum, a| sum * x + a)
    }

    /// Its coefficients in `z`, highest first, where its variable is `(z - 1)/period_s`.
    pub fn at_difference(&self, period_s: f64) -> Vec<f64> {
        let mut sum: Vec<f64> = Vec::new();
        for coefficient in self.0.iter().rev() {
            // Times (z - 1)/T, plus the coefficient.
            let mut product: Vec<f64> = sum.iter().map(|a| a / period_s).collect();
            product.push(0.0);
            for (place, a) in product.iter_mut().skip(1).zip(&sum) {
                *place -= a / period_s;
            }
            if let Some(last) = product.last_mut() {
                *last += coefficient;
            }
            sum = product;
        }
        sum
    }

    /// The polynomial raised to `power`.
    pub fn power(&self, power: usize) -> Self {
        (0..power).fold(Self::new([1.0]), |product, _| &product * self)
    }

    /// Whether every root has a negative real part, by Routh's criterion.
    ///
    /// Returns false for a root on the imaginary axis, including the origin, and for NaN.
    ///
    /// ```
    /// use host_sim::analysis::polynomial::Polynomial;
    /// assert!(Polynomial::new([900.0, 54.0, 1.0]).is_hurwitz());
    /// assert!(!Polynomial::new([900.0, 0.0, 1.0]).is_hurwitz());
    /// ```
    pub fn is_hurwitz(&self) -> bool {
        let descending: Vec<f64> = self.0.iter().rev().copied().collect();
        has_no_sign_change_in_routh_table(descending)
    }

    /// Whether for every root `(z - 1)/period_s` the value `z` is inside the unit circle.
    ///
    /// The bilinear transform `x = s/(1 - s period_s/2)` maps the unit disc to the left half-plane.
    /// With a period of zero it is the identity, and the result is that of [`Self::is_hurwitz`].
    pub fn is_stable(&self, period_s: f64) -> bool {
        let s = Self::new([0.0, 1.0]);
        let factor = Self::new([1.0, -0.5 * period_s]);
        let mut scale = Self::new([1.0]);
        let mut mapped = Self::new([0.0]);
        for (i, a) in self.0.iter().rev().enumerate() {
            if i > 0 {
                scale = &scale * &factor;
            }
            mapped = &(&mapped * &s) + &(&scale * &Self::new([*a]));
        }
        // A root at z = -1 is mapped to infinity: the highest coefficient vanishes.
        mapped.0.len() == self.0.len() && mapped.is_hurwitz()
    }
}

/// Whether the first column of Routh's table has one sign. Coefficients from the highest power.
fn has_no_sign_change_in_routh_table(mut a: Vec<f64>) -> bool {
    while a.len() > 1 {
        let ratio = a[0] / a[1];
        // False for NaN. a[1] = 0 gives infinity or NaN.
        if !(ratio > 0.0 && ratio.is_finite()) {
            return false;
        }
        for i in (2..a.len()).step_by(2) {
            let next = a.get(i + 1).copied().unwrap_or(0.0);
            a[i] -= ratio * next;
        }
        a.remove(0);
    }
    true
}

impl Mul for &Polynomial {
    type Output = Polynomial;

    fn mul(self, other: Self) -> Polynomial {
        let mut product = vec![0.0; (self.0.len() + other.0.len()).saturating_sub(1)];
        for (i, a) in self.0.iter().enumerate() {
            for (j, b) in other.0.iter().enumerate() {
                product[i + j] += a * b;
            }
        }
        Polynomial::new(product)
    }
}

impl Add for &Polynomial {
    type Output = Polynomial;

    fn add(self, other: Self) -> Polynomial {
        let term = |p: &Polynomial, i: usize| p.0.get(i).copied().unwrap_or(0.0);
        let len = self.0.len().max(other.0.len());
        let sum: Vec<f64> = (0..len).map(|i| term(self, i) + term(other, i)).collect();
        Polynomial::new(sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The real polynomial with these real roots and these pairs of complex roots.
    fn with_roots(real: &[f64], pairs: &[(f64, f64)]) -> Polynomial {
        let lines = real.iter().map(|r| Polynomial::new([-r, 1.0]));
        let pairs = pairs
            .iter()
            .map(|(re, im)| Polynomial::new([re * re + im * im, -2.0 * re, 1.0]));
        lines
            .chain(pairs)
            .fold(Polynomial::new([1.0]), |p, factor| &p * &factor)
    }

    /// A real part far enough from zero that rounding does not change its sign.
    fn part() -> impl Strategy<Value = f64> {
        prop_oneof![-50.0..-0.05f64, 0.05..5.0f64]
    }

    proptest! {
        #[test]
        fn stability_of_a_continuous_system_agrees_with_its_roots(
            real in prop::collection::vec(part(), 0..3),
            pairs in prop::collection::vec((part(), 0.0..50.0f64), 0..3),
        ) {
            let left = real.iter().chain(pairs.iter().map(|p| &p.0)).all(|r| *r < 0.0);
            prop_assert_eq!(with_roots(&real, &pairs).is_hurwitz(), left);
        }

        #[test]
        fn stability_of_a_sampled_system_agrees_with_its_roots(
            real in prop::collection::vec(-1.2..1.2f64, 0..3),
            pairs in prop::collection::vec((0.0..1.2f64, 0.0..3.1f64), 0..3),
            period_s in 0.001..0.1f64,
        ) {
            let radii = || real.iter().chain(pairs.iter().map(|p| &p.0)).map(|r| r.abs());
            prop_assume!(radii().all(|r| (r - 1.0).abs() > 1e-3));
            let delta = |z: f64| (z - 1.0) / period_s;
            let real: Vec<f64> = real.iter().map(|z| delta(*z)).collect();
            let pairs: Vec<_> = pairs
                .iter()
                .map(|(r, angle)| (delta(r * angle.cos()), r * angle.sin() / period_s))
                .collect();
            let inside = radii().all(|r| r < 1.0);
            prop_assert_eq!(with_roots(&real, &pairs).is_stable(period_s), inside);
        }

        #[test]
        fn no_coefficients_cause_a_panic(
            coefficients in prop::collection::vec(any::<f64>(), 0..8),
            period_s in any::<f64>(),
        ) {
            let polynomial = Polynomial::new(coefficients);
            polynomial.is_hurwitz();
            polynomial.is_stable(period_s);
        }
    }

    #[test]
    fn a_root_on_the_stability_boundary_is_not_stable() {
        assert!(!Polynomial::new([0.0, 1.0]).is_stable(0.0), "s = 0");
        assert!(!Polynomial::new([0.0, 1.0]).is_stable(0.5), "z = 1");
        assert!(!Polynomial::new([4.0, 1.0]).is_stable(0.5), "z = -1");
        assert!(
            !Polynomial::new([4.0, 5.0, 1.0]).is_stable(0.5),
            "z = -1 and 0.5"
        );
        assert!(Polynomial::new([3.9, 1.0]).is_stable(0.5), "z = -0.95");
    }
}
