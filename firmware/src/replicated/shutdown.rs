//! The shutdown of a program whose data or flash are corrupt: the motor brakes for a second, the
//! fault is reported, and the processor restarts. The program then reports corrupt data, unless its
//! flash is corrupt, which it finds at each start.
//!
//! Before it begins, its state is that of a shutdown that brakes, and each flag is a byte of which
//! every bit counts: any bit that flips begins a shutdown that brakes, or has no effect on the
//! motor.

use canopen::cia402::{Cia402State, statusword};
use model_core::time::CONTROL_RATE_HZ;

use crate::{
    faults::Fault,
    interface::{BoardState, Bridge, Outputs},
};

/// Control periods until the restart: in a second the shorted motor stops a shaft with twice the
/// inertia of motor and gears (`docs/faults.md`: time constant).
pub const BRAKING_PERIODS: u32 = CONTROL_RATE_HZ;

/// Content of the backup register after a restart by a shutdown; any other content means another
/// reset.
pub const RESTART_MARK: u32 = 0x5341_0016;

/// A flag that is set unless all bits of its byte are clear. A `bool` has one bit: after another
/// one has flipped, each branch may take it for a different value.
#[derive(Debug, Clone, Copy)]
pub(super) struct Flag(pub u8);

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
#[derive(Debug, Clone)]
pub struct Shutdown {
    pub(super) has_begun: Flag,
    /// Whether the motor brakes, or is free.
    pub(super) brakes: Flag,
    /// Whether the program is corrupt, and not the data.
    pub(super) is_of_program: Flag,
    periods: u32,
}

impl Default for Shutdown {
    fn default() -> Self {
        Self {
            has_begun: Flag::new(false),
            brakes: Flag::new(true),
            is_of_program: Flag::new(false),
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
                periods: 0,
            };
        }
    }

    /// Whether it has begun: data and program must not be used.
    pub fn has_begun(&self) -> bool {
        self.has_begun.is_set()
    }

    /// The outputs of one control period, after the last ones of the loop; `None` when the
    /// processor is to be restarted.
    pub fn step(&mut self, last: &Outputs) -> Option<Outputs> {
        if self.periods >= BRAKING_PERIODS {
            return None;
        }
        self.periods += 1;
        let fault = if self.is_of_program.is_set() {
            Fault::ProgramCorrupt
        } else {
            Fault::DataCorrupt
        };
        let mut outputs = *last;
        outputs.bridge = if self.brakes.is_set() {
            Bridge::Brake
        } else {
            Bridge::Coast
        };
        outputs.state = BoardState::Fault;
        outputs.fault = Some(fault);
        outputs.motion.state = Cia402State::Fault;
        outputs.motion.status = statusword::FAULT;
        outputs.telemetry.tick = last.telemetry.tick.wrapping_add(1);
        outputs.telemetry.latched.put(fault, true);
        // The last one belongs to another control period, and the protections have ended.
        outputs.telemetry.counter = 0;
        Some(outputs)
    }
}
