//! Which parts of the program have been heard of, from the interrupts that they run in to the
//! supervisor in the control step.

use core::sync::atomic::{AtomicU8, Ordering::Relaxed};

use firmware::supervisor::{Part, Supervisor};

static HEARD: AtomicU8 = AtomicU8::new(0);

/// A part is alive.
pub fn from(part: Part) {
    HEARD.fetch_or(1 << part as u8, Relaxed);
}

/// Tells the supervisor whom it was heard of since the last call.
pub fn tell(supervisor: &mut Supervisor) {
    supervisor.report_all(HEARD.swap(0, Relaxed));
}
