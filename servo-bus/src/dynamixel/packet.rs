//! The view of a packet.

use super::crc;
use crate::bytes::{Bytes, CAPACITY};
use crate::receiver::{self, Scan};

const HEADER: [u8; 4] = [0xFF, 0xFF, 0xFD, 0x00];

/// Bytes of a packet before those that its length counts.
const BEFORE: usize = 7;

/// Delimits packets.
#[derive(Debug)]
pub struct Framing;

impl receiver::Framing for Framing {
    fn scan(bytes: &[u8]) -> Scan {
        let known = bytes.len().min(HEADER.len());
        if bytes.get(..known) != HEADER.get(..known) {
            return Scan::Noise;
        }
        let [_, _, _, _, id, low, high, ..] = *bytes else {
            return Scan::Part;
        };
        let length = usize::from(u16::from_le_bytes([low, high]));
        let total = BEFORE + length;
        if matches!(id, 0xFD | 0xFF) || length < 3 || total > CAPACITY {
            return Scan::Noise;
        }
        match bytes.get(..total) {
            None => Scan::Part,
            Some(packet) if Packet::try_new(packet).is_some() => Scan::Packet(total),
            Some(_) => Scan::Noise,
        }
    }
}

/// A packet whose form and CRC are right.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Packet<'a>(&'a [u8]);

impl<'a> Packet<'a> {
    /// These bytes as one packet.
    pub fn try_new(bytes: &'a [u8]) -> Option<Self> {
        let [
            0xFF,
            0xFF,
            0xFD,
            0x00,
            _,
            low,
            high,
            _,
            ..,
            crc_low,
            crc_high,
        ] = *bytes
        else {
            return None;
        };
        let length = usize::from(u16::from_le_bytes([low, high]));
        let body = bytes.get(..bytes.len() - 2)?;
        let is_right = BEFORE + length == bytes.len()
            && crc(0, body) == u16::from_le_bytes([crc_low, crc_high]);
        is_right.then_some(Self(bytes))
    }

    /// The ID.
    pub fn id(&self) -> u8 {
        self.0.get(4).copied().unwrap_or(0)
    }

    /// Instruction and parameters, without the bytes that were stuffed.
    pub fn body(&self) -> Bytes {
        let mut body = Bytes::default();
        let mut is_stuffed = false;
        for byte in self.0.get(BEFORE..self.0.len() - 2).unwrap_or_default() {
            if !(is_stuffed && *byte == 0xFD) {
                body.push(*byte);
            }
            is_stuffed = !is_stuffed && body.ends_with(&[0xFF, 0xFF, 0xFD]);
        }
        body
    }
}

/// A packet with this instruction and these parameters, which must fit.
pub fn encode(id: u8, instruction: u8, parameters: &[&[u8]]) -> Bytes {
    let mut bytes = Bytes::default();
    bytes.extend(&HEADER);
    bytes.extend(&[id, 0, 0, instruction]);
    for byte in parameters.iter().copied().flatten() {
        bytes.push(*byte);
        if bytes.ends_with(&[0xFF, 0xFF, 0xFD]) {
            bytes.push(0xFD);
        }
    }
    let length = (bytes.len() + 2 - BEFORE) as u16;
    if let Some(place) = bytes.get_mut(5..BEFORE) {
        place.copy_from_slice(&length.to_le_bytes());
    }
    link(&mut bytes, 0);
    bytes
}

/// Begins a packet without stuffing whose rest others send.
pub(super) fn begin(id: u8, instruction: u8, length: u16) -> Bytes {
    let mut bytes = Bytes::default();
    bytes.extend(&HEADER);
    bytes.push(id);
    bytes.extend(&length.to_le_bytes());
    bytes.push(instruction);
    bytes
}

/// Appends the CRC to a part of a packet, of which the parts before have this CRC, or 0; returns
/// that for the next part.
pub fn link(bytes: &mut Bytes, before: u16) -> u16 {
    let sum = crc(before, bytes).to_le_bytes();
    bytes.extend(&sum);
    crc(before, bytes)
}
