//! What follows from each fault.

use super::{Fault, FaultSet};

/// What the board does when it latches a fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reaction {
    /// All switches open from the next PWM edge on: the motor coasts.
    Coast,
    /// The shaft is brought to rest by the quick-stop ramp, then all switches open.
    QuickStop,
}

/// What is known of a fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Description {
    /// The fault.
    pub fault: Fault,
    /// What the board does.
    pub reaction: Reaction,
}

impl Fault {
    /// What the board does when it latches this fault while it drives.
    pub const fn reaction(self) -> Reaction {
        match self {
            // Angle, current and motor are known and well: they can bring the shaft to rest.
            Self::MagnetWeak
            | Self::FollowingError
            | Self::OverTemperature
            | Self::CommandTimeout
            | Self::BusOff => Reaction::QuickStop,
            _ => Reaction::Coast,
        }
    }
}

/// Faults that are latched whether the board drives or not.
pub const ALWAYS: FaultSet = FaultSet::of(&[
    Fault::BridgeTripped,
    Fault::LoopOverrun,
    Fault::ParametersCorrupt,
    Fault::WatchdogReset,
]);
