//! What the node wants of the CAN controller: from the node's interrupt to those of the bus.

use core::sync::atomic::{AtomicU16, AtomicU32, Ordering::Relaxed};

/// The bit rate to go over to, kbit/s; 0 for none.
static BIT_RATE: AtomicU16 = AtomicU16::new(0);

/// How often frames from the bus were lost, and how often the controller left the bus.
static LOST: AtomicU32 = AtomicU32::new(0);
static BUS_OFFS: AtomicU32 = AtomicU32::new(0);

/// Asks for a bit rate, kbit/s.
pub fn ask_bit_rate(kbit_s: u16) {
    BIT_RATE.store(kbit_s, Relaxed);
}

/// The bit rate that was asked for since the last call.
pub fn take_bit_rate() -> Option<u16> {
    match BIT_RATE.swap(0, Relaxed) {
        0 => None,
        kbit_s => Some(kbit_s),
    }
}

/// Frames from the bus were lost.
pub fn lost() {
    LOST.fetch_add(1, Relaxed);
}

/// The controller left the bus.
pub fn left_the_bus() {
    BUS_OFFS.fetch_add(1, Relaxed);
}

/// How often frames were lost, and how often the controller left the bus.
pub fn counts() -> (u32, u32) {
    (LOST.load(Relaxed), BUS_OFFS.load(Relaxed))
}
