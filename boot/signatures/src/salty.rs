//! Checks signatures by `salty`.

#![no_std]
#![no_main]
#![allow(unsafe_code, reason = "symbols for the emulator")]

mod checks;

use cortex_m_rt::entry;
use salty::{PublicKey, Signature};

/// The function whose instructions are counted.
#[unsafe(no_mangle)]
#[inline(never)]
fn verify(key: &[u8; 32], message: &[u8], signature: &[u8; 64]) -> bool {
    let Ok(key) = PublicKey::try_from(key) else {
        return false;
    };
    key.verify(message, &Signature::from(signature)).is_ok()
}

#[entry]
fn main() -> ! {
    checks::run(verify)
}
