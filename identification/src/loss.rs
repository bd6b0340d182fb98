//! How a residual counts in the cost.
//!
//! The square of a residual is the logarithm of the likelihood of normal noise, under which a
//! reading that is off by a hundred standard deviations counts as much as ten thousand others. The
//! loss of Student's distribution with four degrees of freedom, `nu s^2 ln(1 + r^2/(nu s^2))`,
//! equals the square for small residuals and grows with the logarithm of large ones (Lange, Little
//! and Taylor, JASA 84, 1989, "Robust statistical modeling using the t distribution").

/// Degrees of freedom: the value that Lange, Little and Taylor recommend where they are not
/// estimated.
const FREEDOM: f64 = 4.0;

/// The loss of one residual.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Loss {
    /// Its square.
    #[default]
    Squares,
    /// That of Student's distribution with four degrees of freedom.
    Student {
        /// Its scale, deg: the standard deviation of the residuals that are no outliers.
        scale_deg: f64,
    },
}

/// The choice of a loss in a search.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum LossChoice {
    /// Squares, and [`LossChoice::Robust`] where isolated residuals decide the fit.
    #[default]
    Auto,
    /// Squares.
    Squares,
    /// Student's, with the scale of the residuals.
    Robust,
    /// This one, so that several models are compared by one cost.
    Given(Loss),
}

impl LossChoice {
    /// The names of the choices of [`named`](Self::named).
    pub const NAMES: [&str; 3] = ["auto", "squares", "robust"];

    /// The choice of this name.
    ///
    /// ```
    /// use identification::loss::LossChoice;
    /// assert_eq!(LossChoice::named("robust"), Some(LossChoice::Robust));
    /// assert_eq!(LossChoice::named("cubes"), None);
    /// ```
    pub fn named(name: &str) -> Option<Self> {
        let choices = [Self::Auto, Self::Squares, Self::Robust];
        let place = Self::NAMES.iter().position(|known| *known == name)?;
        Some(choices[place])
    }
}

impl Loss {
    /// `1/(nu s^2)`; zero for squares.
    #[inline]
    pub fn curvature(self) -> f64 {
        match self {
            Self::Squares => 0.0,
            Self::Student { scale_deg } => 1.0 / (FREEDOM * scale_deg * scale_deg),
        }
    }

    /// Twice the contribution of a residual to the cost, deg^2, and its weight, the derivative of
    /// the contribution by the half square.
    ///
    /// ```
    /// use identification::loss::Loss;
    /// assert_eq!(Loss::Squares.of(3.0), (9.0, 1.0));
    /// // A residual of two scales has half the weight.
    /// assert_eq!(Loss::Student { scale_deg: 1.0 }.of(2.0).1, 0.5);
    /// ```
    pub fn of(self, residual: f64) -> (f64, f64) {
        weighed(self.curvature(), residual)
    }

    /// A residual with the influence that it has on the estimates: for normal noise the residual
    /// itself, so that the covariance of least squares applies to it (Huber, Robust Statistics,
    /// 1981, section 7.6). `mean_slope` is that of [`mean_slope`](Self::mean_slope).
    pub fn influence(self, residual: f64, mean_slope: f64) -> f64 {
        self.of(residual).1 * residual / mean_slope
    }

    /// The mean derivative of the influence by the residual.
    pub fn mean_slope(self, residuals: impl Iterator<Item = f64>) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0_f64);
        for residual in residuals {
            let weight = self.of(residual).1;
            // d/dr of r/(1 + k r^2), with k r^2 = 1/w - 1.
            sum += weight * (2.0 * weight - 1.0);
            count += 1.0;
        }
        // Not positive only where most residuals are outliers.
        (sum / count.max(1.0)).max(0.1)
    }
}

/// [`Loss::of`] with the curvature of the loss.
#[inline(always)]
pub fn weighed(curvature: f64, residual: f64) -> (f64, f64) {
    let square = residual * residual;
    if curvature == 0.0 {
        return (square, 1.0);
    }
    let share = curvature * square;
    (share.ln_1p() / curvature, 1.0 / (1.0 + share))
}
