//! What remains of the program when its data or its flash are corrupt: it brakes, reports the
//! fault, and restarts the processor.

use canopen::CanFrame;
use firmware::{
    application::Bridge, drive::emergency_frame, faults::Fault, integrity::restart_mark,
};

use super::timing::CONTROL_RATE_HZ;
use crate::peripherals::backup;

/// Control periods until the restart: in a second the shorted motor stops a shaft with twice the
/// inertia of motor and gears (`docs/faults.md`: time constant).
const BRAKING_PERIODS: u32 = CONTROL_RATE_HZ;

/// The end of the program.
pub struct Shutdown {
    fault: Fault,
    /// Whether the motor was driven.
    brakes: bool,
    periods: u32,
    frame: Option<CanFrame>,
}

impl Shutdown {
    /// Starts it. The motor brakes if it was driven, and otherwise remains free.
    pub fn new(fault: Fault, brakes: bool, node_id: u8) -> Self {
        Self {
            fault,
            brakes,
            periods: 0,
            frame: emergency_frame(fault, node_id),
        }
    }

    /// The EMCY message, once.
    pub fn take_frame(&mut self) -> Option<CanFrame> {
        self.frame.take()
    }

    /// One control period. After the last one it does not return.
    pub fn step(&mut self) -> Bridge {
        self.periods += 1;
        if self.periods > BRAKING_PERIODS {
            restart(self.fault);
        }
        if self.brakes {
            Bridge::Brake
        } else {
            Bridge::Coast
        }
    }
}

/// Restarts the processor; the program then reports this fault.
fn restart(fault: Fault) -> ! {
    backup::write(restart_mark(fault));
    cortex_m::peripheral::SCB::sys_reset()
}

/// The mark of the last restart, once. The clock of the power controller is enabled.
pub fn take_mark() -> u32 {
    let mark = backup::read();
    backup::write(0);
    mark
}
