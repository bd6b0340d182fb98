//! The classical fourth-order Runge-Kutta method with a fixed step.

/// The state at `h` after `y`, where `f` is the derivative of the state.
///
/// Returns `y` if the result is not finite, so that NaN and infinity never enter a state.
///
/// ```
/// let [y] = model_core::models::rk4::step([1.0], 0.1, |[y]| [-y]);
/// assert!((y - libm::exp(-0.1)).abs() < 1e-7);
/// assert_eq!(model_core::models::rk4::step([1.0], 0.1, |_| [f64::NAN]), [1.0]);
/// ```
#[inline]
pub fn step<const N: usize>(y: [f64; N], h: f64, f: impl Fn([f64; N]) -> [f64; N]) -> [f64; N] {
    let along = |k: [f64; N], dt: f64| core::array::from_fn(|i| y[i] + dt * k[i]);
    let k1 = f(y);
    let k2 = f(along(k1, 0.5 * h));
    let k3 = f(along(k2, 0.5 * h));
    let k4 = f(along(k3, h));
    let sum = core::array::from_fn(|i| k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
    let next = along(sum, h / 6.0);
    if next.iter().all(|value| value.is_finite()) {
        next
    } else {
        y
    }
}

#[cfg(test)]
mod tests {
    use super::step;

    /// Error of an undamped oscillator after one period in `steps` steps.
    fn error(steps: u32) -> f64 {
        let h = core::f64::consts::TAU / f64::from(steps);
        let mut y = [1.0, 0.0];
        for _ in 0..steps {
            y = step(y, h, |[x, v]| [v, -x]);
        }
        libm::hypot(y[0] - 1.0, y[1])
    }

    #[test]
    fn halving_the_step_reduces_the_error_sixteenfold() {
        let ratio = error(100) / error(200);
        // Fourth order in the limit; the next order contributes about 1/100 here.
        assert!((ratio - 16.0).abs() < 0.3, "ratio {ratio}");
    }
}
