//! The grid on which the plant moves.

use crate::time::PWM_PERIOD_NS;

/// Where the window for the back-EMF opens in a PWM period, ns: 100 us before its end.
pub const WINDOW_NS: u64 = PWM_PERIOD_NS - 100_000;

/// A piece of a PWM period.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Slot {
    /// From its start to the window.
    Head,
    /// The window.
    Tail,
}

impl Slot {
    /// Its start in the period, ns.
    pub const fn from_ns(self) -> u64 {
        match self {
            Self::Head => 0,
            Self::Tail => WINDOW_NS,
        }
    }

    /// Its end in the period, ns.
    pub const fn until_ns(self) -> u64 {
        match self {
            Self::Head => WINDOW_NS,
            Self::Tail => PWM_PERIOD_NS,
        }
    }

    pub(super) fn length_s(self) -> f64 {
        (self.until_ns() - self.from_ns()) as f64 * 1e-9
    }
}
