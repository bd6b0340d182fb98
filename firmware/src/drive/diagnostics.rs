//! What only the board can count.

use crate::supervisor::ResetCause;

/// Counters of object 2050h that the program of the board keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Diagnostics {
    /// The longest control step so far, us.
    pub longest_step_us: u32,
    /// Frames that found no room on their way to the bus.
    pub transmit_overflows: u32,
    /// Frames from the bus that were lost.
    pub receive_overflows: u32,
    /// How often the controller left the bus.
    pub bus_offs: u32,
    /// Why the board was reset.
    pub reset_cause: ResetCause,
    /// Control periods in which a late part kept the watchdog unfed.
    pub starved_periods: u32,
    /// Serial number, sub-index 4 of the identity.
    pub serial_number: u32,
}
