//! The view of a packet.

use crate::bytes::Bytes;
use crate::receiver::{self, Scan};

/// Bytes of a packet but its parameters.
const OVERHEAD: usize = 6;

/// Delimits packets.
#[derive(Debug)]
pub struct Framing;

impl receiver::Framing for Framing {
    fn scan(bytes: &[u8]) -> Scan {
        match *bytes {
            [0xFF] | [] | [0xFF, 0xFF] | [0xFF, 0xFF, 0..=0xFE] => Scan::Part,
            [0xFF, 0xFF, 0..=0xFE, length @ 2..=0xFF, ..] => {
                let total = usize::from(length) + 4;
                match bytes.get(..total) {
                    None => Scan::Part,
                    Some(packet) if Packet::try_new(packet).is_some() => Scan::Packet(total),
                    Some(_) => Scan::Noise,
                }
            }
            _ => Scan::Noise,
        }
    }
}

/// A packet whose form and check value are right.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Packet<'a>(&'a [u8]);

impl<'a> Packet<'a> {
    /// These bytes as one packet.
    ///
    /// ```
    /// use servo_bus::feetech::Packet;
    ///
    /// let packet = Packet::try_new(&[0xFF, 0xFF, 1, 4, 2, 0x38, 2, 0xBE]).unwrap();
    /// assert_eq!((packet.id(), packet.code(), packet.parameters()), (1, 2, &[0x38, 2][..]));
    /// assert_eq!(Packet::try_new(&[0xFF, 0xFF, 1, 4, 2, 0x38, 2, 0xBF]), None);
    /// ```
    pub fn try_new(bytes: &'a [u8]) -> Option<Self> {
        let [0xFF, 0xFF, body @ .., check] = bytes else {
            return None;
        };
        let [_, length, _, ..] = *body else {
            return None;
        };
        let is_right = usize::from(length) + 4 == bytes.len() && checksum(body) == *check;
        is_right.then_some(Self(bytes))
    }

    /// The ID.
    pub fn id(&self) -> u8 {
        self.0.get(2).copied().unwrap_or(0)
    }

    /// The instruction, or of an answer the status.
    pub fn code(&self) -> u8 {
        self.0.get(4).copied().unwrap_or(0)
    }

    /// The parameters.
    pub fn parameters(&self) -> &'a [u8] {
        self.0.get(5..self.0.len() - 1).unwrap_or_default()
    }
}

fn checksum(body: &[u8]) -> u8 {
    !body.iter().fold(0, |sum: u8, byte| sum.wrapping_add(*byte))
}

/// A packet with these contents; parameters beyond 253 bytes are left out.
pub fn encode(id: u8, code: u8, parameters: &[u8]) -> Bytes {
    let most = usize::from(u8::MAX) + 4 - OVERHEAD;
    let parameters = parameters.get(..most).unwrap_or(parameters);
    let mut bytes = Bytes::default();
    bytes.extend(&[0xFF, 0xFF, id, parameters.len() as u8 + 2, code]);
    bytes.extend(parameters);
    let check = checksum(bytes.get(2..).unwrap_or_default());
    bytes.push(check);
    bytes
}
