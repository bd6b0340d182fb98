//! Test inputs by integer tick, exact on every target.
//!
//! A command is a function of the tick alone: no cursor, no history, no floating point. The board
//! asks at every 80th tick, the simulation at every one, a delayed reader asks for the past, and
//! all get the same bits. Floating point serves the constructors only; the fields are integers that
//! a `const` can hold or a bus can carry.
//!
//! [`catalogue`] lists the standard inputs with their parameters by name.

pub mod catalogue;
pub mod chirp;
pub mod exp2;
pub mod multisine;
pub mod multistep;
pub mod phase;
pub mod prbs;
pub mod quotient;
pub mod ramp;
pub mod recorded;
pub mod sine;
pub mod steady_sine;
pub mod variable_step;

use crate::control::units::Angle;
use core::num::NonZeroU64;

/// A test input.
///
/// ```
/// use model_core::excitation::{Excitation, multistep::Multistep};
/// let pulse = Excitation::Multistep(Multistep::try_pulse(&Default::default()).unwrap());
/// assert_eq!([0, 20_000].map(|tick| pulse.command(tick).to_num::<i32>()), [0, 90]);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Excitation<'a> {
    /// Pulse, doublet, 3-2-1-1.
    Multistep(multistep::Multistep),
    /// Levels of equal length.
    VariableStep(variable_step::VariableStep<'a>),
    /// Straight lines.
    Ramp(ramp::Ramp),
    /// A sweep of the frequency, linear or logarithmic.
    Chirp(chirp::Chirp),
    /// One frequency.
    Sine(steady_sine::SteadySine),
    /// A pseudo-random binary sequence.
    Prbs(prbs::Prbs),
    /// Many frequencies at once.
    Multisine(multisine::Multisine),
    /// A recorded sequence.
    Recorded(recorded::Recorded<'a>),
}

impl Excitation<'_> {
    /// The command at a tick. Beyond its end an input holds its final value.
    pub fn command(&self, tick: u64) -> Angle {
        match self {
            Self::Multistep(input) => input.command(tick),
            Self::VariableStep(input) => input.command(tick),
            Self::Ramp(input) => input.command(tick),
            Self::Chirp(input) => input.command(tick),
            Self::Sine(input) => input.command(tick),
            Self::Prbs(input) => input.command(tick),
            Self::Multisine(input) => input.command(tick),
            Self::Recorded(input) => input.command(tick),
        }
    }

    /// Ticks until all of it has been seen: the end of what ends, a period of what repeats itself.
    pub fn duration_ticks(&self) -> u64 {
        match self {
            Self::Multistep(input) => input.duration_ticks(),
            Self::VariableStep(input) => input.duration_ticks(),
            Self::Ramp(input) => input.duration_ticks(),
            Self::Chirp(input) => input.duration_ticks,
            Self::Sine(input) => input.period_ticks,
            Self::Prbs(input) => input.duration_ticks(),
            Self::Multisine(input) => input.period_ticks,
            Self::Recorded(input) => input.duration_ticks(),
        }
    }
}

/// The whole product. On the board all inputs share this one.
#[cfg_attr(target_os = "none", inline(never))]
const fn product(a: i64, b: i64) -> i128 {
    a as i128 * b as i128
}

/// The angle of so many of its least steps; beyond its ends the last one.
#[cfg_attr(target_os = "none", inline(never))]
const fn saturated(bits: i128) -> Angle {
    if bits > i64::MAX as i128 {
        Angle::MAX
    } else if bits < i64::MIN as i128 {
        Angle::MIN
    } else {
        Angle::from_bits(bits as i64)
    }
}

/// `ticks`, or one where there are none.
fn at_least_one(ticks: u64) -> NonZeroU64 {
    NonZeroU64::new(ticks).unwrap_or(NonZeroU64::MIN)
}

#[cfg(test)]
mod tests;
