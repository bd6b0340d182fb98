//! A sine with one frequency sweep.

use super::phase::{Exponential, Quadratic};
use super::sine::{scaled, sine};
use crate::control::units::{Angle, angle};
use crate::parameter::ParameterError;
use crate::time::ticks;

crate::parameters! {
    /// A chirp, linear or logarithmic.
    pub struct ChirpParameters {
        /// Amplitude.
        amplitude_deg [""]: 5.0, "deg", -32768.0, 32767.0, "the rate limits do not show below 7 Hz; the paper prints none";
        /// Frequency at the start.
        start_hz ["f0"]: 0.1, "Hz", 1e-4, 1000.0, "far below the bandwidth; the paper prints none";
        /// Frequency at the end.
        end_hz ["f1"]: 10.0, "Hz", 1e-4, 1000.0, "twice the bandwidth of 4.775 Hz; the paper prints none";
        /// Duration of the sweep; the command is zero after it.
        duration_s ["T"]: 20.0, "s", 1e-3, 3600.0, "the paper prints none";
    }
}

/// Law of the frequency sweep.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Sweep {
    /// Linear in time.
    Linear(Quadratic),
    /// Exponential in time: linear in octaves.
    Logarithmic(Exponential),
}

/// A sweep that starts with phase zero at tick 0 and is zero after its end.
///
/// ```
/// use model_core::control::units::angle;
/// use model_core::excitation::{chirp::{Chirp, Sweep}, phase::Quadratic};
/// // Evaluated at compile time: the board needs no floating point.
/// const CHIRP: Chirp = Chirp {
///     amplitude: angle(5.0),
///     duration_ticks: 400_000,
///     sweep: Sweep::Linear(Quadratic::sweep(0.1, 10.0, 400_000)),
/// };
/// assert!((CHIRP.command(20_000).to_f64() - 4.0907).abs() < 1e-4);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Chirp {
    /// Amplitude.
    pub amplitude: Angle,
    /// Duration of the sweep.
    pub duration_ticks: u64,
    /// Law of the frequency sweep.
    pub sweep: Sweep,
}

impl Chirp {
    /// A chirp whose frequency is a linear function of time.
    ///
    /// ```
    /// use model_core::excitation::chirp::{Chirp, ChirpParameters};
    /// let chirp = Chirp::try_linear(&ChirpParameters::default()).unwrap();
    /// // Ten turns are made after 6.1576 s, at tick 123,152.
    /// assert!(chirp.command(123_150).to_f64() < 0.0 && chirp.command(123_154).to_f64() > 0.0);
    /// ```
    ///
    /// # Errors
    /// [`ParameterError::OutOfRange`] of the first parameter that is NaN or outside its range.
    pub fn try_linear(parameters: &ChirpParameters) -> Result<Self, ParameterError> {
        parameters.check()?;
        let duration_ticks = ticks(parameters.duration_s);
        let sweep = Quadratic::sweep(parameters.start_hz, parameters.end_hz, duration_ticks);
        Ok(Self {
            amplitude: angle(parameters.amplitude_deg),
            duration_ticks,
            sweep: Sweep::Linear(sweep),
        })
    }

    /// A chirp whose frequency is an exponential function of time.
    ///
    /// ```
    /// use model_core::excitation::chirp::{Chirp, ChirpParameters};
    /// let chirp = Chirp::try_logarithmic(&ChirpParameters::default()).unwrap();
    /// // After 10 s it is at 1 Hz and has made (1 - 0.1) * 20/ln 100 = 3.9087 turns.
    /// assert!((chirp.command(200_000).to_f64() + 2.7148).abs() < 1e-4);
    /// ```
    ///
    /// # Errors
    /// [`ParameterError::OutOfRange`] of the first parameter that is NaN or outside its range.
    pub fn try_logarithmic(parameters: &ChirpParameters) -> Result<Self, ParameterError> {
        let mut chirp = Self::try_linear(parameters)?;
        let ticks = chirp.duration_ticks;
        // If the two frequencies are too close, the linear law is equivalent.
        if let Some(sweep) = Exponential::sweep(parameters.start_hz, parameters.end_hz, ticks) {
            chirp.sweep = Sweep::Logarithmic(sweep);
        }
        Ok(chirp)
    }

    /// The command at a tick.
    pub fn command(&self, tick: u64) -> Angle {
        if tick >= self.duration_ticks {
            return Angle::ZERO;
        }
        let phase = match &self.sweep {
            Sweep::Linear(law) => law.at(tick),
            Sweep::Logarithmic(law) => law.at(tick),
        };
        scaled(self.amplitude, sine(phase).to_bits().into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_logarithmic_chirp_between_equal_frequencies_is_a_sine() {
        let steady = ChirpParameters {
            start_hz: 2.0,
            end_hz: 2.0,
            ..Default::default()
        };
        let chirp = Chirp::try_logarithmic(&steady).unwrap();
        // An eighth of a second is a quarter of a turn.
        assert_eq!(chirp.command(2_500), angle(5.0));
    }

    #[test]
    fn each_law_makes_the_number_of_turns_of_its_closed_form() {
        let turns = |chirp: Chirp, until: u64| {
            let positive = |tick| chirp.command(tick) > Angle::ZERO;
            (1..until)
                .filter(|&i| positive(i) && !positive(i - 1))
                .count()
        };
        let parameters = ChirpParameters::default();
        // In the first half: 20 s/8 * (3 * 0.1 + 10) Hz, and 3.9 from the doctest.
        assert_eq!(turns(Chirp::try_linear(&parameters).unwrap(), 200_000), 26);
        assert_eq!(
            turns(Chirp::try_logarithmic(&parameters).unwrap(), 200_000),
            4
        );
    }
}
