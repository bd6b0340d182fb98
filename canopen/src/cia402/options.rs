//! Option codes 605Ah to 605Eh.

/// Deceleration of a stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Deceleration {
    /// Slow down ramp: profile deceleration 6084h.
    SlowDown,
    /// Quick stop ramp: quick stop deceleration 6085h.
    QuickStop,
    /// At the current or voltage limit: the velocity demand is zero immediately.
    Limit,
}

/// Option code of shutdown 605Bh, disable operation 605Ch, halt 605Dh and fault reaction 605Eh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StopOption {
    /// Disables the drive function immediately; the motor coasts.
    Disable,
    /// Decelerates, then disables the drive function; after a halt the drive remains in "operation
    /// enabled".
    Stop(Deceleration),
}

impl StopOption {
    /// Option codes 0 to 4; `None` for others.
    ///
    /// ```
    /// use canopen::cia402::{Deceleration, StopOption};
    /// assert_eq!(StopOption::from_code(0), Some(StopOption::Disable));
    /// assert_eq!(StopOption::from_code(2), Some(StopOption::Stop(Deceleration::QuickStop)));
    /// assert_eq!(StopOption::from_code(5), None);
    /// ```
    #[must_use]
    pub const fn from_code(code: i16) -> Option<Self> {
        Some(match code {
            0 => Self::Disable,
            1 => Self::Stop(Deceleration::SlowDown),
            2 => Self::Stop(Deceleration::QuickStop),
            3 | 4 => Self::Stop(Deceleration::Limit),
            _ => return None,
        })
    }
}

/// Quick stop option code 605Ah.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct QuickStop {
    /// Stop function.
    pub stop: StopOption,
    /// The drive remains in "quick stop active", from where operation may be enabled again.
    pub remains_active: bool,
}

impl QuickStop {
    /// Option codes 0 to 8; `None` for others.
    ///
    /// ```
    /// use canopen::cia402::QuickStop;
    /// assert!(QuickStop::from_code(6).is_some_and(|option| option.remains_active));
    /// assert_eq!(QuickStop::from_code(9), None);
    /// ```
    #[must_use]
    pub const fn from_code(code: i16) -> Option<Self> {
        let (code, remains_active) = if code > 4 {
            (code - 4, true)
        } else {
            (code, false)
        };
        match StopOption::from_code(code) {
            Some(stop) => Some(Self {
                stop,
                remains_active,
            }),
            None => None,
        }
    }
}
