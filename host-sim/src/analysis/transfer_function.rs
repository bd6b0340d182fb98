//! Rational transfer functions, continuous or sampled, with a transport delay.
//!
//! The variable is the delta operator `(z - 1)/T` (Middleton and Goodwin, "Improved finite word
//! length characteristics in digital control using delta operators", IEEE TAC 31, 1986). For `T =
//! 0` it is `s`, so that the same formulas apply to both. For poles near `z = 1`, such as those of
//! a motor sampled at 250 Hz, it is numerically more accurate than polynomials in `z`.

use super::polynomial::Polynomial;
use num_complex::Complex64;
use std::f64::consts::PI;

/// A ratio of polynomials in `(z - 1)/T`, or in `s`, with a transport delay.
#[derive(Debug, Clone, PartialEq)]
pub struct TransferFunction {
    numerator: Polynomial,
    denominator: Polynomial,
    period_s: f64,
    delay_s: f64,
}

impl TransferFunction {
    /// A continuous system: polynomials in `s`.
    ///
    /// ```
    /// use host_sim::analysis::{polynomial::Polynomial, transfer_function::TransferFunction};
    /// let integrator = TransferFunction::continuous(Polynomial::new([1.0]), Polynomial::new([0.0, 1.0]));
    /// assert!((integrator.at(1.0).norm() - 0.159155).abs() < 1e-6);
    /// ```
    pub fn continuous(numerator: Polynomial, denominator: Polynomial) -> Self {
        Self::sampled(numerator, denominator, 0.0)
    }

    /// A system sampled every `period_s` seconds: polynomials in `(z - 1)/period_s`.
    ///
    /// ```
    /// use host_sim::analysis::{polynomial::Polynomial, transfer_function::TransferFunction};
    /// // 1/z: one sample of delay, -90 deg at half the Nyquist frequency
    /// let one = Polynomial::new([1.0]);
    /// let delay = TransferFunction::sampled(one, Polynomial::new([1.0, 0.004]), 0.004);
    /// assert!((delay.at(62.5).arg().to_degrees() + 90.0).abs() < 1e-9);
    /// ```
    pub fn sampled(numerator: Polynomial, denominator: Polynomial, period_s: f64) -> Self {
        Self {
            numerator,
            denominator,
            period_s,
            delay_s: 0.0,
        }
    }

    /// Adds `delay_s` seconds of transport delay, which is outside any loop (0.0175 s for the
    /// paper's test set-up).
    #[must_use]
    pub fn delayed(mut self, delay_s: f64) -> Self {
        self.delay_s += delay_s;
        self
    }

    /// Transport delay, s.
    pub fn delay_s(&self) -> f64 {
        self.delay_s
    }

    /// The Nyquist frequency, Hz; infinite for a continuous system.
    pub fn nyquist_hz(&self) -> f64 {
        0.5 / self.period_s
    }

    /// Numerator and denominator of a sampled system in `z`, highest power first, without the
    /// transport delay.
    ///
    /// ```
    /// use host_sim::analysis::{polynomial::Polynomial, transfer_function::TransferFunction};
    /// // An integrator by forward Euler, 0.5/(z - 1).
    /// let (one, x) = (Polynomial::new([1.0]), Polynomial::new([0.0, 1.0]));
    /// let integrator = TransferFunction::sampled(one, x, 0.5);
    /// assert_eq!(integrator.in_z(), (vec![1.0], vec![2.0, -2.0]));
    /// ```
    pub fn in_z(&self) -> (Vec<f64>, Vec<f64>) {
        let of = |polynomial: &Polynomial| polynomial.at_difference(self.period_s);
        (of(&self.numerator), of(&self.denominator))
    }

    /// Its value at a frequency, including the delay.
    pub fn at(&self, frequency_hz: f64) -> Complex64 {
        let turn = -2.0 * PI * frequency_hz * self.delay_s;
        self.rational_at(frequency_hz) * Complex64::from_polar(1.0, turn)
    }

    /// Its value at a frequency without the transport delay.
    pub fn rational_at(&self, frequency_hz: f64) -> Complex64 {
        let x = self.variable(frequency_hz);
        self.numerator.at(x) / self.denominator.at(x)
    }

    /// Steady-state gain. Infinite or NaN if it has none.
    pub fn steady_gain(&self) -> f64 {
        self.rational_at(0.0).norm()
    }

    /// Whether every pole is stable: in the left half-plane, or inside the unit circle.
    pub fn is_stable(&self) -> bool {
        self.denominator.is_stable(self.period_s)
    }

    /// Closes the loop around `open` with negative feedback. The forward path from the input to the
    /// output is `forward_numerator` over the denominator of `open`.
    pub fn closing(open: &Self, forward_numerator: Polynomial) -> Self {
        let characteristic = &open.denominator + &open.numerator;
        Self::sampled(forward_numerator, characteristic, open.period_s)
    }

    /// `(exp(j w T) - 1)/T`, computed without cancellation. It is `j w` for `T = 0`.
    fn variable(&self, frequency_hz: f64) -> Complex64 {
        let w = 2.0 * PI * frequency_hz;
        if self.period_s == 0.0 {
            return Complex64::new(0.0, w);
        }
        let half = 0.5 * w * self.period_s;
        Complex64::I * Complex64::from_polar(2.0 * half.sin() / self.period_s, half)
    }
}
