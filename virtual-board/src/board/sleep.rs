//! Sleep time of the core of a board.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use rigless::mcu::{Mcu, Operate};
use rigless::time::VirtualNanos;

/// Until when a core sleeps unless its chip wakes it. Its core writes it, and its run reads it
/// between two instructions.
#[derive(Debug, Clone, Default)]
pub(crate) struct Sleep(Arc<AtomicU64>);

impl Sleep {
    /// The core runs, or is about to run.
    pub fn end(&self) {
        self.0.store(0, Relaxed);
    }

    /// The core sleeps until its own next event.
    pub fn begin(&self, event: Option<VirtualNanos>) {
        self.0.store(event.map_or(u64::MAX, |at| at.0), Relaxed);
    }

    /// The instant until which the program cannot act, ns: its core sleeps, and neither its chip
    /// nor the run, which stops next at `next_stop_ns`, can wake it. 0 if the run has just acted on
    /// the chip, which may wake the core.
    pub fn quiet_until_ns(&self, chip: &dyn Mcu, has_acted: bool, next_stop_ns: u64) -> u64 {
        if has_acted {
            return 0;
        }
        let event_ns = chip.next_event().map_or(u64::MAX, |at| at.0);
        self.0.load(Relaxed).min(event_ns).min(next_stop_ns)
    }
}
