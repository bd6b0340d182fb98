//! Test inputs as functions of the integer tick, bit-identical on every target.
//!
//! A command depends on the tick only: there is no internal state and no floating point. The board
//! evaluates every 80th tick, the simulation every tick, a delayed reader past ticks, and all
//! obtain the same bits. Only constructors use floating point; the fields are integers, suitable
//! for a `const` or for transmission over a bus.
//!
//! [`catalogue`] lists the standard inputs with their parameters by name.

pub mod catalogue;
pub mod chirp;
pub mod exp2;
pub mod multisine;
pub mod multistep;
pub mod phase;
pub mod prbs;
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
/// assert_eq!([0, 20_000].map(|tick| pulse.command(tick).to_int()), [0, 90]);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Excitation<'a> {
    /// Pulse, doublet, 3-2-1-1.
    Multistep(multistep::Multistep),
    /// Levels of equal duration.
    VariableStep(variable_step::VariableStep<'a>),
    /// Straight lines between breakpoints.
    Ramp(ramp::Ramp),
    /// A frequency sweep, linear or logarithmic.
    Chirp(chirp::Chirp),
    /// One frequency.
    Sine(steady_sine::SteadySine),
    /// A pseudo-random binary sequence.
    Prbs(prbs::Prbs),
    /// Several frequencies simultaneously.
    Multisine(multisine::Multisine),
    /// A recorded sequence.
    Recorded(recorded::Recorded<'a>),
}

impl Excitation<'_> {
    /// The command at a tick. After its end an input keeps its final value.
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

    /// Duration in ticks: until the end of a finite input, or one period of a periodic one.
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

/// The full product.
const fn product(a: i64, b: i64) -> i128 {
    a as i128 * b as i128
}

/// The angle with this number of LSBs, saturated.
const fn saturated(bits: i128) -> Angle {
    if bits > i64::MAX as i128 {
        Angle::MAX
    } else if bits < i64::MIN as i128 {
        Angle::MIN
    } else {
        Angle::from_bits(bits as i64)
    }
}

/// `ticks`, at least one.
fn at_least_one(ticks: u64) -> NonZeroU64 {
    NonZeroU64::new(ticks).unwrap_or(NonZeroU64::MIN)
}

#[cfg(test)]
mod tests;
