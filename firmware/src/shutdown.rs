//! The shutdown of a program whose data or flash are corrupt: the motor brakes for a second, the
//! fault is reported, and the processor restarts. The program then reports corrupt data, unless its
//! flash is corrupt, which it finds at each start.
//!
//! Before it begins, its state is that of a shutdown that brakes, and each flag is a byte of which
//! every bit counts: any bit that flips begins a shutdown that brakes, or has no effect on the
//! motor.

use canopen::CanFrame;
use model_core::time::CONTROL_RATE_HZ;

use crate::{drive::emergency_frame, faults::Fault, interface::Bridge};

/// Control periods until the restart: in a second the shorted motor stops a shaft with twice the
/// inertia of motor and gears (`docs/faults.md`: time constant).
pub const BRAKING_PERIODS: u32 = CONTROL_RATE_HZ;

/// Content of the backup register after a restart by a shutdown; any other content means another
/// reset.
pub const RESTART_MARK: u32 = 0x5341_0016;

/// A flag that is set unless all bits of its byte are clear. A `bool` has one bit: after another
/// one has flipped, each branch may take it for a different value.
#[derive(Debug, Clone, Copy)]
struct Flag(u8);

impl Flag {
    /// A flag that one flipped bit does not clear.
    fn new(is_set: bool) -> Self {
        Self(if is_set { u8::MAX } else { 0 })
    }

    fn is_set(self) -> bool {
        self.0 != 0
    }
}

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
#[derive(Debug, Clone)]
pub struct Shutdown {
    has_begun: Flag,
    /// Whether the motor brakes, or is free.
    brakes: Flag,
    /// Whether the program is corrupt, and not the data.
    is_of_program: Flag,
    is_reported: Flag,
    periods: u32,
}

impl Default for Shutdown {
    fn default() -> Self {
        Self {
            has_begun: Flag::new(false),
            brakes: Flag::new(true),
            is_of_program: Flag::new(false),
            is_reported: Flag::new(false),
            periods: 0,
        }
    }
}

impl Shutdown {
    /// Begins it because of corrupt data, or of [`Fault::ProgramCorrupt`], unless it has begun.
    pub fn begin(&mut self, fault: Fault, brakes: bool) {
        if !self.has_begun() {
            *self = Self {
                has_begun: Flag::new(true),
                brakes: Flag::new(brakes),
                is_of_program: Flag::new(fault == Fault::ProgramCorrupt),
                ..Self::default()
            };
        }
    }

    /// Whether it has begun: data and program must not be used.
    pub fn has_begun(&self) -> bool {
        self.has_begun.is_set()
    }

    /// The EMCY frame of the fault from the node of this number, once.
    pub fn take_frame(&mut self, node_id: u8) -> Option<CanFrame> {
        if self.is_reported.is_set() {
            return None;
        }
        self.is_reported = Flag::new(true);
        let fault = if self.is_of_program.is_set() {
            Fault::ProgramCorrupt
        } else {
            Fault::DataCorrupt
        };
        emergency_frame(fault, node_id)
    }

    /// One control period; returns `None` when the processor is to be restarted.
    pub fn step(&mut self) -> Option<Bridge> {
        if self.periods >= BRAKING_PERIODS {
            return None;
        }
        self.periods += 1;
        Some(if self.brakes.is_set() {
            Bridge::Brake
        } else {
            Bridge::Coast
        })
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use std::vec::Vec;

    use super::*;

    fn flags(shutdown: &mut Shutdown) -> [&mut Flag; 4] {
        [
            &mut shutdown.has_begun,
            &mut shutdown.brakes,
            &mut shutdown.is_of_program,
            &mut shutdown.is_reported,
        ]
    }

    /// This shutdown with each bit of its flags flipped in turn.
    fn flipped(shutdown: &Shutdown) -> impl Iterator<Item = Shutdown> {
        (0..4 * u8::BITS).map(|bit| {
            let mut flipped = shutdown.clone();
            flags(&mut flipped)[(bit / u8::BITS) as usize].0 ^= 1 << (bit % u8::BITS);
            flipped
        })
    }

    fn brakes_for_a_second(mut shutdown: Shutdown) -> bool {
        let brakes = (0..CONTROL_RATE_HZ).all(|_| shutdown.step() == Some(Bridge::Brake));
        brakes && shutdown.step().is_none()
    }

    #[test]
    fn a_flipped_bit_begins_a_shutdown_that_brakes_for_a_second_and_reports_corrupt_data() {
        let begun: Vec<_> = flipped(&Shutdown::default())
            .filter(Shutdown::has_begun)
            .collect();
        assert_eq!(begun.len(), 8);
        for mut shutdown in begun {
            let frame = shutdown.take_frame(1);
            assert_eq!(frame, emergency_frame(Fault::DataCorrupt, 1));
            assert!(brakes_for_a_second(shutdown));
        }
    }

    #[test]
    fn a_flipped_bit_in_a_shutdown_that_brakes_does_not_release_the_motor() {
        let mut shutdown = Shutdown::default();
        shutdown.begin(Fault::DataCorrupt, true);
        for flipped in flipped(&shutdown) {
            assert!(flipped.has_begun());
            assert!(brakes_for_a_second(flipped));
        }
    }

    #[test]
    fn the_begin_replaces_whatever_the_state_was_before() {
        let mut shutdown = Shutdown {
            brakes: Flag(0),
            is_of_program: Flag(1),
            is_reported: Flag(1),
            periods: u32::MAX,
            ..Shutdown::default()
        };
        shutdown.begin(Fault::DataCorrupt, true);
        let frame = shutdown.take_frame(5);
        assert_eq!(frame, emergency_frame(Fault::DataCorrupt, 5));
        assert!(brakes_for_a_second(shutdown));
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
