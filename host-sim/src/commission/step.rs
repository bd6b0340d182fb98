//! The steps of a commissioning, by which a refusal is reported.

use std::fmt;

/// A step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// The program itself has failed.
    Program,
    /// Wiring, and what the board must be for all steps.
    Wiring,
    /// Gain of the current measurement.
    Current,
    /// Resistance of the winding.
    Resistance,
    /// Magnet, and error of the encoder.
    Encoder,
    /// Stops of the shaft.
    Stops,
    /// Runs at constant rate.
    Runs,
    /// Friction, by these runs.
    Friction,
    /// Inertia and delay.
    Dynamics,
    /// Gains and their verification.
    Tuning,
    /// Middle of the range.
    Centre,
    /// Write of what was found.
    Write,
}

impl Step {
    /// The number by which docs/commissioning.md explains it.
    pub fn number(self) -> u8 {
        match self {
            Self::Program => 0,
            Self::Wiring => 1,
            Self::Current | Self::Resistance => 2,
            Self::Encoder => 3,
            Self::Runs | Self::Friction | Self::Stops => 4,
            Self::Dynamics => 5,
            Self::Tuning => 6,
            Self::Centre => 8,
            Self::Write => 9,
        }
    }
}

impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Program => "commissioning",
            Self::Wiring => "wiring",
            Self::Current => "current",
            Self::Resistance => "resistance",
            Self::Encoder => "encoder",
            Self::Stops => "stops",
            Self::Runs => "runs at constant rate",
            Self::Friction => "friction",
            Self::Dynamics => "inertia and delay",
            Self::Tuning => "tuning",
            Self::Centre => "centre",
            Self::Write => "write",
        })
    }
}
