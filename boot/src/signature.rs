//! Signatures of images: Ed25519 (RFC 8032) of the header, which contains the SHA-512 of the
//! program.

use salty::{PublicKey, Sha512, Signature};

/// Checks signatures.
pub trait Verifier {
    /// Whether this is the signature of the message by the key of this number.
    fn verify(&self, key: u32, message: &[u8], signature: &[u8; 64]) -> bool;
}

/// A public key.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Key(pub [u8; 32]);

impl Key {
    /// Its number in the header of an image: the first four bytes.
    pub const fn number(&self) -> u32 {
        let Self([a, b, c, d, ..]) = *self;
        u32::from_le_bytes([a, b, c, d])
    }
}

impl Verifier for Key {
    fn verify(&self, key: u32, message: &[u8], signature: &[u8; 64]) -> bool {
        if key != self.number() {
            return false;
        }
        let Ok(public) = PublicKey::try_from(&self.0) else {
            return false;
        };
        public.verify(message, &Signature::from(signature)).is_ok()
    }
}

/// SHA-512 of a program.
pub fn image_hash(program: &[u8]) -> [u8; 64] {
    let mut hash = Sha512::new();
    hash.update(program);
    hash.finalize()
}

/// The private key of the development key: public, hence refused by a bootloader that
/// is built without the feature `development-key`.
pub const DEVELOPMENT_SEED: [u8; 32] = *b"smart-actuator, development only";

/// The public key of [`DEVELOPMENT_SEED`]; a test compares the two.
pub const DEVELOPMENT_KEY: Key = Key([
    0x77, 0x2c, 0xb4, 0x77, 0x04, 0x11, 0xc6, 0x2d, 0x72, 0xef, 0x1f, 0xed, 0x6f, 0x56, 0xe3, 0x3e,
    0xea, 0x18, 0x54, 0x91, 0xc9, 0x52, 0xa3, 0x7d, 0x07, 0xc6, 0x59, 0xd7, 0xf3, 0x13, 0x3b, 0x93,
]);
