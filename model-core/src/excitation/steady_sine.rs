//! A sine of constant frequency without end.

use super::phase::Quadratic;
use super::sine::{scaled, sine};
use crate::control::units::{Angle, angle};
use crate::parameter::ParameterError;
use crate::time::ticks;

crate::parameters! {
    /// A sine.
    pub struct SineParameters {
        /// Amplitude.
        amplitude_deg [""]: 20.0, "deg", -32768.0, 32767.0, "126 deg/s at 1 Hz: half the rate limit; the paper prints none";
        /// Frequency.
        frequency_hz ["f"]: 1.0, "Hz", 1e-4, 1000.0, "within the bandwidth; the paper prints none";
    }
}

/// A sine that starts with phase zero at tick 0 and never ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct SteadySine {
    /// Amplitude.
    pub amplitude: Angle,
    /// Phase, from [`Quadratic::steady`].
    pub phase: Quadratic,
    /// Ticks of one period, rounded.
    pub period_ticks: u64,
}

impl SteadySine {
    /// A sine with these parameters.
    ///
    /// ```
    /// use model_core::excitation::steady_sine::{SineParameters, SteadySine};
    /// let sine = SteadySine::try_new(&SineParameters::default()).unwrap();
    /// assert_eq!([0, 5_000, 15_000].map(|i| sine.command(i).to_int()), [0, 20, -20]);
    /// ```
    ///
    /// # Errors
    /// [`ParameterError::OutOfRange`] of the first parameter that is NaN or outside its range.
    pub fn try_new(parameters: &SineParameters) -> Result<Self, ParameterError> {
        parameters.check()?;
        Ok(Self {
            amplitude: angle(parameters.amplitude_deg),
            phase: Quadratic::steady(parameters.frequency_hz),
            period_ticks: ticks(1.0 / parameters.frequency_hz),
        })
    }

    /// The command at a tick.
    pub fn command(&self, tick: u64) -> Angle {
        scaled(self.amplitude, sine(self.phase.at(tick)).to_bits().into())
    }
}
