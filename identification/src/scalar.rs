//! Numbers that carry their derivatives.
//!
//! A model is written once over [`Scalar`]. With `f64` it is simulated; with [`Dual`] the same code
//! gives its derivatives by up to `N` parameters, exact to rounding (forward-mode automatic
//! differentiation: Griewank and Walther, Evaluating Derivatives, 2nd ed., chapter 3).

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A real number, with derivatives or without.
pub trait Scalar:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Mul<f64, Output = Self>
    + Add<f64, Output = Self>
{
    /// A number that depends on no parameter.
    fn constant(value: f64) -> Self;

    /// Independent variable number `index`.
    fn variable(value: f64, _index: usize) -> Self {
        Self::constant(value)
    }

    /// The number itself.
    fn value(self) -> f64;

    /// A function of it with this value and derivative: the chain rule.
    fn chain(self, value: f64, slope: f64) -> Self;

    /// Its exponential.
    fn exp(self) -> Self {
        let e = self.value().exp();
        self.chain(e, e)
    }

    /// Its natural logarithm.
    fn ln(self) -> Self {
        self.chain(self.value().ln(), 1.0 / self.value())
    }

    /// Its sine.
    fn sin(self) -> Self {
        let (sin, cos) = self.value().sin_cos();
        self.chain(sin, cos)
    }

    /// Its magnitude.
    fn abs(self) -> Self {
        if self.value() < 0.0 { -self } else { self }
    }

    /// Clamped to `low` and `high`.
    fn within(self, low: Self, high: Self) -> Self {
        if self.value() < low.value() {
            low
        } else if self.value() > high.value() {
            high
        } else {
            self
        }
    }
}

impl Scalar for f64 {
    fn constant(value: f64) -> Self {
        value
    }

    fn value(self) -> f64 {
        self
    }

    fn chain(self, value: f64, _slope: f64) -> Self {
        value
    }
}

/// A number with its derivatives by `N` parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dual<const N: usize> {
    /// The number.
    pub value: f64,
    /// Its derivatives.
    pub slope: [f64; N],
}

impl<const N: usize> Dual<N> {
    /// Parameter number `index` itself.
    pub fn parameter(value: f64, index: usize) -> Self {
        let slope = std::array::from_fn(|i| if i == index { 1.0 } else { 0.0 });
        Self { value, slope }
    }

    #[inline(always)]
    fn with(value: f64, of: impl Fn(usize) -> f64) -> Self {
        let mut slope = [0.0; N];
        for (i, place) in slope.iter_mut().enumerate() {
            *place = of(i);
        }
        Self { value, slope }
    }
}

impl<const N: usize> Scalar for Dual<N> {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self {
            value,
            slope: [0.0; N],
        }
    }

    fn variable(value: f64, index: usize) -> Self {
        Self::parameter(value, index)
    }

    #[inline(always)]
    fn value(self) -> f64 {
        self.value
    }

    #[inline(always)]
    fn chain(self, value: f64, slope: f64) -> Self {
        Self::with(value, |i| slope * self.slope[i])
    }
}

impl<const N: usize> Add for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self::with(self.value + other.value, |i| self.slope[i] + other.slope[i])
    }
}

impl<const N: usize> Sub for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self::with(self.value - other.value, |i| self.slope[i] - other.slope[i])
    }
}

impl<const N: usize> Mul for Dual<N> {
    type Output = Self;
    #[expect(clippy::suspicious_arithmetic_impl, reason = "the product rule adds")]
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self::with(self.value * other.value, |i| {
            self.slope[i] * other.value + self.value * other.slope[i]
        })
    }
}

impl<const N: usize> Div for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let inverse = 1.0 / other.value;
        let quotient = self.value * inverse;
        Self::with(quotient, |i| {
            (self.slope[i] - quotient * other.slope[i]) * inverse
        })
    }
}

impl<const N: usize> Neg for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::with(-self.value, |i| -self.slope[i])
    }
}

impl<const N: usize> Mul<f64> for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        Self::with(self.value * factor, |i| self.slope[i] * factor)
    }
}

impl<const N: usize> Add<f64> for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, term: f64) -> Self {
        Self {
            value: self.value + term,
            slope: self.slope,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn expression<S: Scalar>(x: S, y: S) -> S {
        (x * y + x / y - (x * 0.3).exp() + y.ln()).sin() * (y - x).abs()
            + x.within(y * -1.0, y)
            + 1.5
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let step = 1e-6;
        for (x, y) in [(0.7, 1.9), (2.5, 1.1), (-3.0, 0.4)] {
            let dual = expression(Dual::<2>::parameter(x, 0), Dual::<2>::parameter(y, 1));
            assert_eq!(dual.value, expression(x, y));
            let by_x = (expression(x + step, y) - expression(x - step, y)) / (2.0 * step);
            let by_y = (expression(x, y + step) - expression(x, y - step)) / (2.0 * step);
            // Central differences err by step^2 times third derivatives and 1e-16/step: below 1e-8.
            assert!((dual.slope[0] - by_x).abs() < 1e-8, "{dual:?} {by_x}");
            assert!((dual.slope[1] - by_y).abs() < 1e-8, "{dual:?} {by_y}");
        }
    }
}
