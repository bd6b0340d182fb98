//! The frames that wait for the bus.

use embedded_can::Frame;

use crate::assembly::Tail;
use crate::data_types::{
    ACTUATOR_STATUS, ALLOCATION, CIRCUIT_STATUS, DataType, FILE_READ, LOG_MESSAGE, NODE_STATUS,
    TEMPERATURE,
};
use crate::{FrameId, crc::crc};

/// Frames that wait: those of the longest transfer and of some others.
const FRAMES: usize = 48;

/// A transfer to be sent.
#[derive(Debug, Clone, Copy)]
pub struct Outgoing<'a> {
    /// Sender, kind and priority.
    pub id: FrameId,
    /// Its number.
    pub transfer_id: u8,
    /// Its data type.
    pub data_type: DataType,
    /// Its payload.
    pub payload: &'a [u8],
}

#[derive(Debug, Clone, Copy)]
struct Waiting {
    id: embedded_can::ExtendedId,
    bytes: [u8; 8],
    length: u8,
}

/// A queue of frames.
#[derive(Debug)]
pub struct Outbox {
    frames: [Waiting; FRAMES],
    first: usize,
    length: usize,
}

impl Default for Outbox {
    fn default() -> Self {
        Self::new()
    }
}

impl Outbox {
    /// An empty queue.
    #[must_use]
    pub const fn new() -> Self {
        let none = Waiting {
            id: embedded_can::ExtendedId::ZERO,
            bytes: [0; 8],
            length: 0,
        };
        Self {
            frames: [none; FRAMES],
            first: 0,
            length: 0,
        }
    }

    /// Whether no frame waits.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.length == 0
    }

    /// Queues all frames of a transfer, or none if there is no room.
    pub fn push(&mut self, outgoing: &Outgoing<'_>) -> bool {
        let Outgoing { id, payload, .. } = outgoing;
        let sum = crc(outgoing.data_type.signature, payload).to_le_bytes();
        let is_single = payload.len() < 8;
        let count = if is_single {
            1
        } else {
            (payload.len() + sum.len()).div_ceil(7)
        };
        if self.length + count > FRAMES {
            return false;
        }
        let sum = if is_single { &[][..] } else { &sum };
        let mut bytes = sum.iter().chain(*payload).copied();
        // Anonymous messages of different contents have different identifiers.
        let id = id.raw(crc(0, payload));
        for number in 0..count {
            let mut waiting = Waiting {
                id,
                bytes: [0; 8],
                length: 0,
            };
            for (place, byte) in waiting.bytes.iter_mut().zip(bytes.by_ref().take(7)) {
                *place = byte;
                waiting.length += 1;
            }
            let tail = Tail {
                is_start: number == 0,
                is_end: number + 1 == count,
                toggle: number % 2 == 1,
                transfer_id: outgoing.transfer_id,
            };
            if let Some(place) = waiting.bytes.get_mut(usize::from(waiting.length)) {
                *place = tail.byte();
                waiting.length += 1;
            }
            if let Some(place) = self.frames.get_mut((self.first + self.length) % FRAMES) {
                *place = waiting;
                self.length += 1;
            }
        }
        true
    }

    /// The next frame.
    pub fn pop<F: Frame>(&mut self) -> Option<F> {
        self.length = self.length.checked_sub(1)?;
        let waiting = self.frames.get(self.first)?;
        self.first = (self.first + 1) % FRAMES;
        F::new(waiting.id, waiting.bytes.get(..waiting.length.into())?)
    }
}

/// What a node sends by itself.
const SENT: [DataType; 7] = [
    ALLOCATION,
    NODE_STATUS,
    ACTUATOR_STATUS,
    CIRCUIT_STATUS,
    TEMPERATURE,
    LOG_MESSAGE,
    FILE_READ,
];

/// The numbers of the next transfers of each data type.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct TransferIds([u8; SENT.len()]);

impl TransferIds {
    /// The next number.
    pub fn next(&mut self, data_type: DataType) -> u8 {
        let mut numbers = SENT.iter().zip(&mut self.0);
        let Some((_, number)) = numbers.find(|(sent, _)| **sent == data_type) else {
            return 0;
        };
        let next = *number;
        *number = next.wrapping_add(1) & 0x1F;
        next
    }
}

/// Priorities of what a node sends; a response has that of its request.
pub(crate) mod priority {
    pub const STATUS: u8 = 16;
    pub const SLOW: u8 = 24;
    pub const LOWEST: u8 = 30;
}
