//! State of the CAN controller and requests to it, exchanged between its interrupts and the CANopen
//! device.
//!
//! Each value is one atomic: no context waits for another, and no value depends on a second one.

use core::sync::atomic::{AtomicBool, AtomicU8, AtomicU16, AtomicU32, Ordering::Relaxed};

use firmware::application::BusState;

/// Most severe state since it was taken. Bus-off lasts 128 times 11 bits only, 1.4 ms at 1 Mbit/s:
/// a look once in a control period can miss it. The controller interrupts when it enters the state.
static WORST_STATE: AtomicU8 = AtomicU8::new(BusState::Active as u8);

/// Requested bit rate, kbit/s; 0 for none.
static REQUESTED_BIT_RATE: AtomicU16 = AtomicU16::new(0);

static LOST_FRAMES: AtomicU32 = AtomicU32::new(0);
static BUS_OFFS: AtomicU32 = AtomicU32::new(0);

/// Frames that left a mailbox since the reset.
static TRANSMITTED: AtomicU32 = AtomicU32::new(0);

/// The waiting process data shall be discarded.
static DISCARD_REQUESTED: AtomicBool = AtomicBool::new(false);

/// Process data that was discarded since the reset, frames.
static DISCARDED: AtomicU32 = AtomicU32::new(0);

/// Number of the update period of the last turn of the CANopen device, 31 bits.
static PERIOD: AtomicU32 = AtomicU32::new(0);

/// Sets the number of the present update period.
pub fn set_period(period: u32) {
    PERIOD.store(period, Relaxed);
}

/// The number of the update period of the last turn.
pub fn period() -> u32 {
    PERIOD.load(Relaxed)
}

/// Records the present state of the controller.
pub fn record_state(state: BusState) {
    WORST_STATE.fetch_max(state as u8, Relaxed);
}

/// Takes the most severe state since the last call.
pub fn take_worst_state() -> BusState {
    const PASSIVE: u8 = BusState::Passive as u8;
    const ACTIVE: u8 = BusState::Active as u8;
    match WORST_STATE.swap(ACTIVE, Relaxed) {
        ACTIVE => BusState::Active,
        PASSIVE => BusState::Passive,
        _ => BusState::Off,
    }
}

/// Requests a bit rate, kbit/s.
pub fn request_bit_rate(kbit_s: u16) {
    REQUESTED_BIT_RATE.store(kbit_s, Relaxed);
}

/// Takes the bit rate that was requested since the last call, kbit/s.
pub fn take_requested_bit_rate() -> Option<u16> {
    match REQUESTED_BIT_RATE.swap(0, Relaxed) {
        0 => None,
        kbit_s => Some(kbit_s),
    }
}

/// Counts a loss of received frames.
pub fn count_lost_frame() {
    LOST_FRAMES.fetch_add(1, Relaxed);
}

/// Losses of received frames since the reset.
pub fn lost_frames() -> u32 {
    LOST_FRAMES.load(Relaxed)
}

/// Counts a transition to bus-off.
pub fn count_bus_off() {
    BUS_OFFS.fetch_add(1, Relaxed);
}

/// Transitions to bus-off since the reset.
pub fn bus_offs() -> u32 {
    BUS_OFFS.load(Relaxed)
}

/// Counts transmitted frames.
pub fn count_transmitted(frames: u32) {
    TRANSMITTED.fetch_add(frames, Relaxed);
}

/// Frames transmitted since the reset; wraps.
pub fn transmitted() -> u32 {
    TRANSMITTED.load(Relaxed)
}

/// Requests that the process data that waits for the bus be discarded.
pub fn request_discard() {
    DISCARD_REQUESTED.store(true, Relaxed);
}

/// Takes that request.
pub fn take_discard_request() -> bool {
    DISCARD_REQUESTED.swap(false, Relaxed)
}

/// Counts discarded frames.
pub fn count_discarded(frames: u32) {
    DISCARDED.fetch_add(frames, Relaxed);
}

/// Frames discarded since the reset; wraps.
pub fn discarded() -> u32 {
    DISCARDED.load(Relaxed)
}
