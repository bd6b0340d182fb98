//! Signed images of a few words.

use std::{cell::RefCell, collections::HashMap, vec, vec::Vec};

use rand_pcg::{Pcg32, rand_core::Rng};
use salty::Keypair;

use crate::{
    header::{CRC, HEADER_SIZE, Header, Version},
    signature::{Key, Verifier, image_hash},
};

/// The hardware of the tests.
pub const HARDWARE: u32 = 0x5341_0001;

/// Bytes of a program: at most a sector of the slot less than the layout holds.
pub const PROGRAM: usize = 96;

/// The key of the tests.
pub fn keys() -> Keypair {
    Keypair::from(&[7; 32])
}

/// Its public key.
pub fn key() -> Key {
    Key(keys().public.to_bytes())
}

/// A header for a random program of this seed, and the program, not signed.
pub fn draft(version: u32, seed: u64) -> (Header, Vec<u8>) {
    let mut program = vec![0; PROGRAM];
    Pcg32::new(seed, 2).fill_bytes(&mut program);
    let header = Header {
        length: PROGRAM as u32,
        hardware: HARDWARE,
        version: Version(version),
        replaces: Version::default(),
        program_crc: CRC.checksum(&program),
        key: key().number(),
        hash: image_hash(&program),
        signature: [0; 64],
    };
    (header, program)
}

/// The image of header and program, signed by these keys.
pub fn signed(mut header: Header, program: &[u8], keys: &Keypair) -> Vec<u8> {
    header.signature = keys.sign(&header.signed()).to_bytes();
    assemble(&header, program)
}

/// The image of header and program.
pub fn assemble(header: &Header, program: &[u8]) -> Vec<u8> {
    let mut image = vec![0xff; HEADER_SIZE as usize];
    let bytes = header.bytes();
    image[..bytes.len()].copy_from_slice(&bytes);
    image.extend(program);
    image
}

/// A valid image of this version.
pub fn image(version: u32) -> Vec<u8> {
    let (header, program) = draft(version, version.into());
    signed(header, &program, &keys())
}

/// The header of an image.
pub fn header(image: &[u8]) -> Header {
    Header::read(image).expect("a header")
}

/// The verifier of the board, which keeps what it has computed: a test starts it a million
/// times with the same few headers.
#[derive(Debug)]
pub struct Remembering {
    key: Key,
    known: RefCell<HashMap<Vec<u8>, bool>>,
}

impl Remembering {
    /// A verifier with the key of the tests.
    pub fn new() -> Self {
        Self {
            key: key(),
            known: RefCell::default(),
        }
    }
}

impl Verifier for &Remembering {
    fn verify(&self, key: u32, message: &[u8], signature: &[u8; 64]) -> bool {
        let question: Vec<u8> = key
            .to_le_bytes()
            .into_iter()
            .chain(message.iter().copied())
            .chain(*signature)
            .collect();
        let mut known = self.known.borrow_mut();
        *known
            .entry(question)
            .or_insert_with(|| self.key.verify(key, message, signature))
    }
}
