//! Inputs that alternate between plus and minus one amplitude: pulse, doublet, 3-2-1-1.
//!
//! A 3-2-1-1 has a broader spectrum than a doublet: at least half its peak from 0.03 to 0.45
//! divided by the unit, compared with 0.12 to 0.66 (Jategaonkar, "Flight Vehicle System
//! Identification", chapter 2, shows both spectra).

use super::at_least_one;
use crate::control::units::{Angle, angle};
use crate::parameter::ParameterError;
use crate::time::ticks;
use core::num::NonZeroU64;

crate::parameters! {
    /// A rectangular pulse.
    pub struct PulseParameters {
        /// Height.
        amplitude_deg [""]: 90.0, "deg", -32768.0, 32767.0, "half the way to the hard stop; the paper prints none";
        /// Time of the first edge.
        start_s [""]: 1.0, "s", 0.0, 1e6, "the actuator is at rest before";
        /// Time of the second edge.
        end_s [""]: 3.0, "s", 0.0, 1e6, "ample for 90 deg at 240 deg/s; the paper prints none";
    }
}

crate::parameters! {
    /// One unit up, one unit down.
    pub struct DoubletParameters {
        /// Magnitude of both halves.
        amplitude_deg [""]: 20.0, "deg", -32768.0, 32767.0, "as the 3-2-1-1";
        /// Time of the first edge.
        start_s [""]: 1.0, "s", 0.0, 1e6, "the actuator is at rest before";
        /// Width of one half.
        unit_s [""]: 0.3, "s", 50e-6, 1e6, "as the 3-2-1-1";
    }
}

crate::parameters! {
    /// Three units up, two down, one up, one down.
    pub struct ThreeTwoOneOneParameters {
        /// Magnitude of every step.
        amplitude_deg [""]: 20.0, "deg", -32768.0, 32767.0, "reaches the rate limits; the paper prints none";
        /// Time of the first edge.
        start_s [""]: 1.0, "s", 0.0, 1e6, "the actuator is at rest before";
        /// Width of the narrowest step.
        unit_s [""]: 0.3, "s", 50e-6, 1e6, "strong from 0.1 to 1.5 Hz; the paper prints none";
    }
}

/// Steps of alternating sign, the first of them positive; zero before and after.
///
/// ```
/// use core::num::NonZeroU64;
/// use model_core::{control::units::angle, excitation::multistep::Multistep};
/// const DOUBLET: Multistep = Multistep {
///     amplitude: angle(2.5),
///     start_tick: 100,
///     unit_ticks: NonZeroU64::new(10).unwrap(),
///     widths: &[1, 1],
/// };
/// let commands = [99, 100, 110, 120].map(|i| DOUBLET.command(i).to_f64());
/// assert_eq!(commands, [0.0, 2.5, -2.5, 0.0]);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Multistep {
    /// Magnitude of every step; if negative, the first step is downward.
    pub amplitude: Angle,
    /// Tick of the first edge.
    pub start_tick: u64,
    /// Ticks in one unit of width.
    pub unit_ticks: NonZeroU64,
    /// Width of each step in units.
    pub widths: &'static [u8],
}

impl Multistep {
    /// One step up and back; zero if it would end before it starts.
    ///
    /// ```
    /// use model_core::excitation::multistep::{Multistep, PulseParameters};
    /// let pulse = Multistep::try_pulse(&PulseParameters::default()).unwrap();
    /// assert_eq!([19_999, 20_000, 60_000].map(|i| pulse.command(i).to_int()), [0, 90, 0]);
    /// ```
    ///
    /// # Errors
    /// [`ParameterError::OutOfRange`] of the first parameter that is NaN or outside its range.
    pub fn try_pulse(parameters: &PulseParameters) -> Result<Self, ParameterError> {
        parameters.check()?;
        let start_tick = ticks(parameters.start_s);
        let width = NonZeroU64::new(ticks(parameters.end_s).saturating_sub(start_tick));
        Ok(Self {
            amplitude: angle(parameters.amplitude_deg),
            start_tick,
            unit_ticks: width.unwrap_or(NonZeroU64::MIN),
            widths: if width.is_some() { &[1] } else { &[] },
        })
    }

    /// One unit up, one unit down.
    ///
    /// ```
    /// use model_core::excitation::multistep::{DoubletParameters, Multistep};
    /// let doublet = Multistep::try_doublet(&DoubletParameters::default()).unwrap();
    /// assert_eq!([20_000, 26_000].map(|i| doublet.command(i).to_int()), [20, -20]);
    /// ```
    ///
    /// # Errors
    /// [`ParameterError::OutOfRange`] of the first parameter that is NaN or outside its range.
    pub fn try_doublet(parameters: &DoubletParameters) -> Result<Self, ParameterError> {
        parameters.check()?;
        Ok(Self {
            amplitude: angle(parameters.amplitude_deg),
            start_tick: ticks(parameters.start_s),
            unit_ticks: at_least_one(ticks(parameters.unit_s)),
            widths: &[1, 1],
        })
    }

    /// Three units up, two down, one up, one down.
    ///
    /// ```
    /// use model_core::excitation::multistep::{Multistep, ThreeTwoOneOneParameters};
    /// let steps = Multistep::try_3211(&ThreeTwoOneOneParameters::default()).unwrap();
    /// let commands = [37_999, 38_000, 50_000].map(|i| steps.command(i).to_int());
    /// assert_eq!(commands, [20, -20, 20]);
    /// ```
    ///
    /// # Errors
    /// [`ParameterError::OutOfRange`] of the first parameter that is NaN or outside its range.
    pub fn try_3211(parameters: &ThreeTwoOneOneParameters) -> Result<Self, ParameterError> {
        parameters.check()?;
        Ok(Self {
            amplitude: angle(parameters.amplitude_deg),
            start_tick: ticks(parameters.start_s),
            unit_ticks: at_least_one(ticks(parameters.unit_s)),
            widths: &[3, 2, 1, 1],
        })
    }

    /// The command at a tick.
    pub fn command(&self, tick: u64) -> Angle {
        let Some(since) = tick.checked_sub(self.start_tick) else {
            return Angle::ZERO;
        };
        let mut units = since / self.unit_ticks;
        for (step, &width) in self.widths.iter().enumerate() {
            match units.checked_sub(u64::from(width)) {
                Some(rest) => units = rest,
                None if step % 2 == 0 => return self.amplitude,
                None => return self.amplitude.saturating_neg(),
            }
        }
        Angle::ZERO
    }

    /// Ticks until the command remains zero.
    pub fn duration_ticks(&self) -> u64 {
        let units: u64 = self.widths.iter().map(|&width| u64::from(width)).sum();
        self.start_tick
            .saturating_add(units.saturating_mul(self.unit_ticks.get()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area_deg_s(steps: &Multistep) -> f64 {
        let degrees = |tick| steps.command(tick).to_f64();
        (0..steps.duration_ticks() + 100).map(degrees).sum::<f64>() / 20_000.0
    }

    #[test]
    fn a_3_2_1_1_leaves_one_unit_of_area_and_a_doublet_none() {
        // 20 deg * 0.3 s * (3 - 2 + 1 - 1)
        let steps = Multistep::try_3211(&Default::default()).unwrap();
        assert_eq!(area_deg_s(&steps), 6.0);
        let doublet = Multistep::try_doublet(&Default::default()).unwrap();
        assert_eq!(area_deg_s(&doublet), 0.0);
        let pulse = Multistep::try_pulse(&Default::default()).unwrap();
        assert_eq!(area_deg_s(&pulse), 180.0);
    }

    #[test]
    fn a_pulse_that_ends_before_it_starts_is_zero() {
        let backward = PulseParameters {
            start_s: 3.0,
            end_s: 1.0,
            ..Default::default()
        };
        let pulse = Multistep::try_pulse(&backward).unwrap();
        assert!((0..100_000).all(|tick| pulse.command(tick) == Angle::ZERO));
    }

    #[test]
    fn the_smallest_angle_saturates_when_negated() {
        let mut doublet = Multistep::try_doublet(&Default::default()).unwrap();
        doublet.amplitude = Angle::MIN;
        assert_eq!(doublet.command(20_000), Angle::MIN);
        assert_eq!(doublet.command(26_000), Angle::MAX);
    }

    #[test]
    fn a_nan_parameter_is_refused() {
        let bad = PulseParameters {
            end_s: f64::NAN,
            ..Default::default()
        };
        assert!(Multistep::try_pulse(&bad).is_err());
    }
}
