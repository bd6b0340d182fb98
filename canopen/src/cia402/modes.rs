//! Modes of operation 6060h.

/// A mode of operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(i8)]
pub enum Mode {
    /// No mode: the axis is at rest.
    None = 0,
    /// Profile position.
    ProfilePosition = 1,
    /// Profile velocity.
    ProfileVelocity = 3,
    /// Profile torque.
    ProfileTorque = 4,
    /// Homing.
    Homing = 6,
    /// Interpolated position.
    InterpolatedPosition = 7,
    /// Cyclic synchronous position.
    CyclicPosition = 8,
    /// Cyclic synchronous velocity.
    CyclicVelocity = 9,
    /// Cyclic synchronous torque.
    CyclicTorque = 10,
}

impl Mode {
    /// Object 6502h "supported drive modes" with all modes of this enumeration.
    pub const SUPPORTED: u32 =
        1 << 0 | 1 << 2 | 1 << 3 | 1 << 5 | 1 << 6 | 1 << 7 | 1 << 8 | 1 << 9;

    /// The mode of a code of 6060h; `None` if it is not supported.
    ///
    /// ```
    /// use canopen::cia402::Mode;
    /// assert_eq!(Mode::from_code(8), Some(Mode::CyclicPosition));
    /// assert_eq!(Mode::from_code(2), None);
    /// assert_eq!(Mode::SUPPORTED, 0x3ED);
    /// ```
    #[must_use]
    pub const fn from_code(code: i8) -> Option<Self> {
        Some(match code {
            0 => Self::None,
            1 => Self::ProfilePosition,
            3 => Self::ProfileVelocity,
            4 => Self::ProfileTorque,
            6 => Self::Homing,
            7 => Self::InterpolatedPosition,
            8 => Self::CyclicPosition,
            9 => Self::CyclicVelocity,
            10 => Self::CyclicTorque,
            _ => return None,
        })
    }

    /// Whether a master sends a target in each of its periods.
    #[must_use]
    pub const fn is_cyclic(self) -> bool {
        matches!(
            self,
            Self::InterpolatedPosition
                | Self::CyclicPosition
                | Self::CyclicVelocity
                | Self::CyclicTorque
        )
    }

    /// Whether the mode has a torque demand.
    #[must_use]
    pub const fn is_torque(self) -> bool {
        matches!(self, Self::ProfileTorque | Self::CyclicTorque)
    }

    /// Whether the mode has a position demand.
    pub(super) const fn is_position(self) -> bool {
        matches!(
            self,
            Self::ProfilePosition
                | Self::Homing
                | Self::InterpolatedPosition
                | Self::CyclicPosition
        )
    }
}
