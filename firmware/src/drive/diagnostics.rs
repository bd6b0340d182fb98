//! Counters that only the program of the board can keep.

use crate::supervisor::ResetCause;

/// Counters of object 2050h, and the serial number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Diagnostics {
    /// Longest control step, us.
    pub longest_step_us: u32,
    /// Frames that were not sent because the queue was full.
    pub transmit_overflows: u32,
    /// Frames from the bus that were lost.
    pub receive_overflows: u32,
    /// Number of bus-off events.
    pub bus_offs: u32,
    /// Cause of the last reset.
    pub reset_cause: ResetCause,
    /// Control periods in which the watchdog was not fed because a task was late.
    pub starved_periods: u32,
    /// Serial number, sub-index 4 of the identity.
    pub serial_number: u32,
}
