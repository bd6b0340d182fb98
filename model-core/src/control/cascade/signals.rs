//! What goes into a control step and comes out of it.

use crate::control::units::{Angle, Percent, Rate};

/// What the loops are closed around.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Setpoint {
    /// Both loops, around this angle.
    Angle(Angle),
    /// The rate loop alone, around this rate.
    Rate(Rate),
}

impl Setpoint {
    /// The angle around which the loops are closed; `None` around a rate.
    pub const fn angle(self) -> Option<Angle> {
        match self {
            Self::Angle(angle) => Some(angle),
            Self::Rate(_) => None,
        }
    }
}

impl From<Angle> for Setpoint {
    fn from(angle: Angle) -> Self {
        Self::Angle(angle)
    }
}

impl From<Rate> for Setpoint {
    fn from(rate: Rate) -> Self {
        Self::Rate(rate)
    }
}

/// The result of one control step; zero by default.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CascadeStep {
    /// The commanded rate after its limit, deg/s.
    pub rate_command: Rate,
    /// The duty, %.
    pub duty: Percent,
    /// Which limits acted.
    pub limits: ActiveLimits,
}

/// The limits that acted in a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ActiveLimits {
    /// A position limit changed the setpoint.
    pub position: bool,
    /// A rate limit changed the commanded rate.
    pub rate: bool,
    /// The duty limit changed the duty.
    pub duty: bool,
    /// The slew limit changed the duty.
    pub slew: bool,
    /// [`super::CascadeState::limit_duty`] changed the duty: the limit of the motor's current.
    pub current: bool,
}
