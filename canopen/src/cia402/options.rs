//! Option codes: how the drive stops.

/// How it slows down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Deceleration {
    /// With the profile's deceleration 6084h.
    SlowDown,
    /// With the quick stop deceleration 6085h.
    QuickStop,
    /// As fast as current or voltage allow: the demand is zero at once.
    Limit,
}

/// Shutdown 605Bh, disable operation 605Ch, halt 605Dh and fault reaction 605Eh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopOption {
    /// Without power at once; the motor coasts.
    Disable,
    /// Slows down, then goes without power; a halt stays in operation.
    Stop(Deceleration),
}

impl StopOption {
    /// Option code 0 to 4; `None` for others.
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

/// Quick stop 605Ah.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QuickStop {
    /// How it stops.
    pub stop: StopOption,
    /// It stays in "quick stop active", from where operation may be enabled again.
    pub stays: bool,
}

impl QuickStop {
    /// Option code 0 to 8; `None` for others.
    ///
    /// ```
    /// use canopen::cia402::QuickStop;
    /// assert!(QuickStop::from_code(6).is_some_and(|option| option.stays));
    /// assert_eq!(QuickStop::from_code(9), None);
    /// ```
    #[must_use]
    pub const fn from_code(code: i16) -> Option<Self> {
        let (code, stays) = if code > 4 {
            (code - 4, true)
        } else {
            (code, false)
        };
        match StopOption::from_code(code) {
            Some(stop) => Some(Self { stop, stays }),
            None => None,
        }
    }
}
