//! Checks signatures by `ed25519-dalek`.

#![no_std]
#![no_main]

#[allow(unsafe_code, reason = "symbols for the emulator")]
mod checks;

use ed25519_dalek::{Signature, Verifier as _, VerifyingKey};

fn is_right(key: &[u8; 32], message: &[u8], signature: &[u8; 64]) -> bool {
    let signature = Signature::from_bytes(signature);
    VerifyingKey::from_bytes(key).is_ok_and(|key| key.verify(message, &signature).is_ok())
}
