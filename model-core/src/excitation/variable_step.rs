//! A sequence of arbitrary levels of equal duration: the paper's variable step.

use super::{at_least_one, product, saturated};
use crate::control::units::{Angle, angle};
use crate::parameter::ParameterError;
use crate::time::ticks;
use core::num::NonZeroU64;

crate::parameters! {
    /// The variable step over its standard [`LEVELS`].
    pub struct VariableStepParameters {
        /// Duration of each level.
        dwell_s [""]: 0.5, "s", 50e-6, 1e6, "the largest steps do not settle in it, as in the paper; it prints none";
        /// Factor for all levels.
        scale [""]: 1.0, "1", -1000.0, 1000.0, "the levels as they stand";
    }
}

/// The standard levels: small and large steps in both directions, some too large to be followed.
/// The paper prints none.
pub const LEVELS: [Angle; 14] = {
    let degrees = [0, 30, -20, 60, -60, 90, -45, 120, -120, 45, 0, 10, -10, 0];
    let mut levels = [Angle::ZERO; 14];
    let mut k = 0;
    while k < levels.len() {
        levels[k] = Angle::from_int(degrees[k]);
        k += 1;
    }
    levels
};

/// Successive levels; the last one remains.
///
/// ```
/// use core::num::NonZeroU64;
/// use model_core::{control::units::angle, excitation::variable_step::VariableStep};
/// let stairs = VariableStep {
///     levels: &[angle(1.0), angle(-2.0)],
///     dwell_ticks: NonZeroU64::new(5).unwrap(),
///     scale: angle(1.5),
/// };
/// assert_eq!([0, 4, 5, 99].map(|i| stairs.command(i).to_f64()), [1.5, 1.5, -3.0, -3.0]);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct VariableStep<'a> {
    /// The levels; the command is zero if there are none.
    pub levels: &'a [Angle],
    /// Duration of each level in ticks.
    pub dwell_ticks: NonZeroU64,
    /// Factor for all levels, a dimensionless number in the format of an angle.
    pub scale: Angle,
}

impl VariableStep<'static> {
    /// The standard levels with these parameters.
    ///
    /// ```
    /// use model_core::excitation::variable_step::{VariableStep, VariableStepParameters};
    /// let stairs = VariableStep::try_new(&VariableStepParameters::default()).unwrap();
    /// assert_eq!([0, 10_000, 75_000].map(|i| stairs.command(i).to_int()), [0, 30, 120]);
    /// ```
    ///
    /// # Errors
    /// [`ParameterError::OutOfRange`] of the first parameter that is NaN or outside its range.
    pub fn try_new(parameters: &VariableStepParameters) -> Result<Self, ParameterError> {
        parameters.check()?;
        Ok(Self {
            levels: &LEVELS,
            dwell_ticks: at_least_one(ticks(parameters.dwell_s)),
            scale: angle(parameters.scale),
        })
    }
}

impl VariableStep<'_> {
    /// The command at a tick.
    pub fn command(&self, tick: u64) -> Angle {
        // The board's `usize` has 32 bits: an index that does not fit is beyond the last level.
        let index = usize::try_from(tick / self.dwell_ticks).ok();
        let level = index
            .and_then(|index| self.levels.get(index))
            .or(self.levels.last());
        level.map_or(Angle::ZERO, |level| {
            let scaled = product(level.to_bits(), self.scale.to_bits());
            saturated((scaled + (1 << 31)) >> 32)
        })
    }

    /// Ticks until the end of the last level's duration.
    pub fn duration_ticks(&self) -> u64 {
        self.dwell_ticks
            .get()
            .saturating_mul(self.levels.len() as u64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scaled_levels_are_rounded_and_saturated() {
        let parameters = VariableStepParameters {
            scale: -1000.0,
            ..Default::default()
        };
        let mut stairs = VariableStep::try_new(&parameters).unwrap();
        assert_eq!(stairs.command(115_000), angle(-10_000.0));
        stairs.scale = Angle::MIN;
        assert_eq!(stairs.command(75_000), Angle::MIN);
    }

    #[test]
    fn without_levels_the_command_is_zero() {
        let none = VariableStep {
            levels: &[],
            dwell_ticks: NonZeroU64::MIN,
            scale: Angle::ONE,
        };
        assert_eq!(
            (none.command(0), none.command(u64::MAX)),
            (Angle::ZERO, Angle::ZERO)
        );
        assert_eq!(none.duration_ticks(), 0);
    }
}
