//! Checks signatures by `salty`.

#![no_std]
#![no_main]

#[allow(unsafe_code, reason = "symbols for the emulator")]
mod checks;

use salty::{PublicKey, Signature};

fn is_right(key: &[u8; 32], message: &[u8], signature: &[u8; 64]) -> bool {
    PublicKey::try_from(key)
        .is_ok_and(|key| key.verify(message, &Signature::from(signature)).is_ok())
}
