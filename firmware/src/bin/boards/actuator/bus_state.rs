//! The worst that has happened on the bus since it was asked last.
//!
//! Bus-off lasts 128 times 11 bits only, 1.4 ms at 1 Mbit/s: who looks once in a tick may not see it. The
//! controller interrupts when it goes there; that is kept here.

use core::sync::atomic::{AtomicU8, Ordering::Relaxed};

use firmware::application::BusState;

static WORST: AtomicU8 = AtomicU8::new(BusState::Active as u8);

/// Notes a state.
pub fn note(state: BusState) {
    WORST.fetch_max(state as u8, Relaxed);
}

/// The worst since this was asked last.
pub fn take() -> BusState {
    const PASSIVE: u8 = BusState::Passive as u8;
    const ACTIVE: u8 = BusState::Active as u8;
    match WORST.swap(ACTIVE, Relaxed) {
        ACTIVE => BusState::Active,
        PASSIVE => BusState::Passive,
        _ => BusState::Off,
    }
}
