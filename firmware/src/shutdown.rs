//! The shutdown of a program whose data or flash are corrupt: the motor brakes for a second, the
//! fault is reported, and the processor restarts. The program then reports corrupt data, unless its
//! flash is corrupt, which it finds at each start.
//!
//! Its state before the begin is that of a shutdown that brakes: a bit of it that flips begins that
//! one at worst.

use canopen::CanFrame;
use model_core::time::CONTROL_RATE_HZ;

use crate::{drive::emergency_frame, faults::Fault, interface::Bridge};

/// Control periods until the restart: in a second the shorted motor stops a shaft with twice the
/// inertia of motor and gears (`docs/faults.md`: time constant).
pub const BRAKING_PERIODS: u32 = CONTROL_RATE_HZ;

/// Content of a register that survives a restart, for the restart at the end of a shutdown: any
/// other content is that of another reset.
pub const RESTART_MARK: u32 = 0x5341_0016;

/// A shutdown that has begun or not.
///
/// ```
/// use firmware::{faults::Fault, interface::Bridge, shutdown::{BRAKING_PERIODS, Shutdown}};
///
/// let mut shutdown = Shutdown::default();
/// shutdown.begin(Fault::DataCorrupt, true);
/// assert!(shutdown.has_begun());
/// assert!((0..BRAKING_PERIODS).all(|_| shutdown.step() == Some(Bridge::Brake)));
/// assert_eq!(shutdown.step(), None); // restart
/// ```
#[derive(Debug, Clone, Default)]
pub struct Shutdown {
    has_begun: bool,
    /// Whether the motor was free, and remains so.
    is_free: bool,
    /// Whether the program is corrupt, and not the data.
    is_of_program: bool,
    is_reported: bool,
    periods: u32,
}

impl Shutdown {
    /// Begins it because of corrupt data, or of [`Fault::ProgramCorrupt`], unless it has begun. The
    /// motor brakes if it was driven, and otherwise remains free.
    pub fn begin(&mut self, fault: Fault, is_driven: bool) {
        if !self.has_begun {
            *self = Self {
                has_begun: true,
                is_free: !is_driven,
                is_of_program: fault == Fault::ProgramCorrupt,
                ..Self::default()
            };
        }
    }

    /// Whether it has begun: data and program must not be used.
    pub fn has_begun(&self) -> bool {
        self.has_begun
    }

    /// The EMCY frame of the fault from the node of this number, once.
    pub fn take_frame(&mut self, node_id: u8) -> Option<CanFrame> {
        if core::mem::replace(&mut self.is_reported, true) {
            return None;
        }
        let fault = match self.is_of_program {
            true => Fault::ProgramCorrupt,
            false => Fault::DataCorrupt,
        };
        emergency_frame(fault, node_id)
    }

    /// One control period; returns `None` when the processor is to be restarted.
    pub fn step(&mut self) -> Option<Bridge> {
        if self.periods >= BRAKING_PERIODS {
            return None;
        }
        self.periods += 1;
        Some(match self.is_free {
            true => Bridge::Coast,
            false => Bridge::Brake,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shutdown_that_a_flipped_bit_begins_brakes_for_a_second_and_reports_corrupt_data() {
        let mut shutdown = Shutdown {
            has_begun: true,
            ..Shutdown::default()
        };
        let frame = shutdown.take_frame(1);
        assert_eq!(frame, emergency_frame(Fault::DataCorrupt, 1));
        assert!((0..CONTROL_RATE_HZ).all(|_| shutdown.step() == Some(Bridge::Brake)));
        assert_eq!(shutdown.step(), None);
    }

    #[test]
    fn the_begin_replaces_whatever_the_state_was_before() {
        let mut shutdown = Shutdown {
            has_begun: false,
            is_free: true,
            is_of_program: true,
            is_reported: true,
            periods: u32::MAX,
        };
        shutdown.begin(Fault::DataCorrupt, true);
        assert_eq!(shutdown.step(), Some(Bridge::Brake));
        assert_eq!(
            shutdown.take_frame(5),
            emergency_frame(Fault::DataCorrupt, 5)
        );
    }

    #[test]
    fn the_first_fault_decides_and_is_reported_once() {
        let mut shutdown = Shutdown::default();
        shutdown.begin(Fault::ProgramCorrupt, false);
        shutdown.begin(Fault::DataCorrupt, true);
        assert_eq!(shutdown.step(), Some(Bridge::Coast));
        let frame = shutdown.take_frame(1);
        assert_eq!(frame, emergency_frame(Fault::ProgramCorrupt, 1));
        assert_eq!(shutdown.take_frame(1), None);
    }
}
