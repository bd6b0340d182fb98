//! Transfers from their frames.

use crate::{DataType, FrameId, Kind, crc::crc};

/// Longest payload of a received message, its CRC included: fifteen commands of actuators.
const MESSAGE: usize = 2 + 15 * 4;

/// Longest payload of a received service transfer, its CRC included: a response with 256 bytes of a
/// file.
const SERVICE: usize = 2 + 2 + 256;

/// Time after which a transfer that does not go on is given up, us.
const TIMEOUT_US: u64 = 2_000_000;

/// The last byte of each frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Tail {
    pub is_start: bool,
    pub is_end: bool,
    pub toggle: bool,
    /// Number of the transfer among those of its kind, 5 bits.
    pub transfer_id: u8,
}

impl Tail {
    pub const fn parse(byte: u8) -> Self {
        Self {
            is_start: byte & 0x80 != 0,
            is_end: byte & 0x40 != 0,
            toggle: byte & 0x20 != 0,
            transfer_id: byte & 0x1F,
        }
    }

    pub const fn byte(self) -> u8 {
        (self.is_start as u8) << 7
            | (self.is_end as u8) << 6
            | (self.toggle as u8) << 5
            | self.transfer_id & 0x1F
    }
}

/// A received transfer.
#[derive(Debug, Clone, Copy)]
pub struct Transfer<'a> {
    /// Sender, kind and priority.
    pub id: FrameId,
    /// Its number.
    pub transfer_id: u8,
    /// Its payload.
    pub payload: &'a [u8],
}

/// A transfer of several frames that is being received.
#[derive(Debug)]
struct Slot<const N: usize> {
    /// Sender and kind; `None` if the slot is free.
    of: Option<(u8, Kind)>,
    tail: Tail,
    at_us: u64,
    bytes: [u8; N],
    length: usize,
}

impl<const N: usize> Slot<N> {
    const FREE: Self = Self {
        of: None,
        tail: Tail::parse(0),
        at_us: 0,
        bytes: [0; N],
        length: 0,
    };

    /// Takes a frame; returns whether the transfer is complete.
    fn push(&mut self, tail: Tail, data: &[u8], now_us: u64) -> bool {
        if tail.is_start {
            (self.length, self.tail) = (0, tail);
        } else if tail.transfer_id != self.tail.transfer_id || tail.toggle == self.tail.toggle {
            // A frame of another transfer, or one that was repeated.
            return false;
        }
        self.tail.toggle = tail.toggle;
        self.at_us = now_us;
        let Some(place) = (self.bytes.get_mut(self.length..)).and_then(|b| b.get_mut(..data.len()))
        else {
            self.of = None;
            return false;
        };
        place.copy_from_slice(data);
        self.length += data.len();
        if tail.is_end {
            self.of = None;
        }
        tail.is_end
    }

    /// The payload, if its CRC is right.
    fn payload(&self, signature: u64) -> Option<&[u8]> {
        let [low, high, payload @ ..] = self.bytes.get(..self.length)? else {
            return None;
        };
        (u16::from_le_bytes([*low, *high]) == crc(signature, payload)).then_some(payload)
    }
}

/// The transfers that are being received.
#[derive(Debug)]
pub struct Assembly {
    messages: [Slot<MESSAGE>; 3],
    services: [Slot<SERVICE>; 2],
}

impl Default for Assembly {
    fn default() -> Self {
        Self::new()
    }
}

impl Assembly {
    /// None.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            messages: [Slot::FREE; 3],
            services: [Slot::FREE; 2],
        }
    }

    /// Takes a frame of a transfer of this data type; returns the transfer that it completes.
    pub fn receive<'a>(
        &'a mut self,
        id: FrameId,
        data_type: DataType,
        data: &'a [u8],
        now_us: u64,
    ) -> Option<Transfer<'a>> {
        let signature = data_type.signature;
        let (tail, data) = data.split_last()?;
        let tail = Tail::parse(*tail);
        let payload = if tail.is_start && tail.is_end {
            (!tail.toggle).then_some(data)?
        } else if id.source == 0 || (tail.is_start && tail.toggle) {
            return None;
        } else if let Kind::Message(_) = id.kind {
            assemble(&mut self.messages, id, tail, data, now_us)?.payload(signature)?
        } else {
            assemble(&mut self.services, id, tail, data, now_us)?.payload(signature)?
        };
        Some(Transfer {
            id,
            transfer_id: tail.transfer_id,
            payload,
        })
    }
}

/// Adds a frame to its slot; returns the slot if the transfer is complete. A new transfer replaces
/// the one of the same sender and kind, or the oldest one.
fn assemble<'a, const N: usize>(
    slots: &'a mut [Slot<N>],
    id: FrameId,
    tail: Tail,
    data: &[u8],
    now_us: u64,
) -> Option<&'a Slot<N>> {
    let of = Some((id.source, id.kind));
    let present = slots.iter().position(|slot| slot.of == of);
    let place = if tail.is_start {
        let age = |slot: &Slot<N>| {
            slot.of
                .map_or(u64::MAX, |_| now_us.wrapping_sub(slot.at_us))
        };
        let free = (0..).zip(&*slots).max_by_key(|(_, slot)| age(slot));
        present.or(free.map(|(place, _)| place))?
    } else {
        present?
    };
    let slot = slots.get_mut(place)?;
    if !tail.is_start && now_us.wrapping_sub(slot.at_us) > TIMEOUT_US {
        slot.of = None;
        return None;
    }
    slot.of = of;
    slot.push(tail, data, now_us).then_some(&*slot)
}
