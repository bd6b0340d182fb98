//! Adapter between a serial line and a CAN bus.

use super::line::{hex, parse};
use super::{Acceptance, KBIT_S, SlcanLine, flags};
use crate::CanFrame;

const DONE: &[u8] = b"\r";
const BELL: &[u8] = b"\x07";
/// Length of the command buffer, longer than any command.
const COMMAND_LENGTH_MAX: usize = 32;

/// The bus side of an [`Adapter`].
pub trait Bus {
    /// Opens the bus at `kbit_s`, one of [`KBIT_S`], or at the present bit rate if the client
    /// selected none; in listen-only mode, without acknowledging frames, if `silent`. Returns
    /// whether it succeeded.
    fn open(&mut self, kbit_s: Option<u16>, silent: bool) -> bool;

    /// Closes the bus.
    fn close(&mut self);

    /// Queues a frame for transmission; `false` if the queue is full.
    fn send(&mut self, frame: &CanFrame) -> bool;

    /// State of the controller and events since the previous call: bits of [`flags`].
    fn flags(&mut self) -> u8;
}

/// Timestamp of received frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Timestamps {
    /// No timestamp.
    #[default]
    None,
    /// Milliseconds, wrapping to 0 after 59,999.
    Milliseconds,
    /// Microseconds, wrapping to 0 after 3,599,999,999.
    Microseconds,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ChannelState {
    Closed,
    Open,
    Silent,
}

/// One adapter.
#[derive(Clone, Debug)]
pub struct Adapter {
    serial: [u8; 4],
    state: ChannelState,
    kbit_s: Option<u16>,
    timestamps: Timestamps,
    acceptance: Acceptance,
    latched: u8,
    line: [u8; COMMAND_LENGTH_MAX],
    /// Received length of the line; a line longer than [`COMMAND_LENGTH_MAX`] is invalid.
    length: usize,
}

impl Adapter {
    /// A closed adapter with a serial number of four letters or digits.
    #[must_use]
    pub const fn new(serial: [u8; 4]) -> Self {
        Self {
            serial,
            state: ChannelState::Closed,
            kbit_s: None,
            timestamps: Timestamps::None,
            acceptance: Acceptance {
                code: 0,
                mask: u32::MAX,
            },
            latched: 0,
            line: [0; COMMAND_LENGTH_MAX],
            length: 0,
        }
    }

    /// Receives a byte of the serial line; returns the answer at the end of a command.
    ///
    /// ```
    /// use canopen::{CanFrame, slcan::{Adapter, Bus}};
    /// struct Wire(Vec<CanFrame>);
    /// impl Bus for Wire {
    ///     fn open(&mut self, _: Option<u16>, _: bool) -> bool { true }
    ///     fn close(&mut self) {}
    ///     fn send(&mut self, frame: &CanFrame) -> bool { self.0.push(*frame); true }
    ///     fn flags(&mut self) -> u8 { 0 }
    /// }
    /// let (mut adapter, mut wire) = (Adapter::new(*b"0001"), Wire(Vec::new()));
    /// let mut answers = Vec::new();
    /// for byte in b"O\rt1232AABB\rV\r" {
    ///     if let Some(text) = adapter.receive(*byte, &mut wire) {
    ///         answers.extend_from_slice(text.as_bytes());
    ///     }
    /// }
    /// assert_eq!(answers, b"\rz\rV1013\r");
    /// assert_eq!(wire.0.len(), 1);
    /// ```
    pub fn receive(&mut self, byte: u8, bus: &mut impl Bus) -> Option<SlcanLine> {
        // Some clients end a line with CR and LF.
        if byte == b'\n' {
            return None;
        }
        if byte != b'\r' {
            if let Some(place) = self.line.get_mut(self.length) {
                *place = byte;
            }
            self.length = self.length.saturating_add(1);
            return None;
        }
        let (line, length) = (self.line, core::mem::take(&mut self.length));
        let answer = line.get(..length).and_then(|line| self.execute(line, bus));
        Some(answer.unwrap_or(SlcanLine::of(BELL)))
    }

    /// The line of a frame received from the bus; `None` if the adapter is closed or the acceptance
    /// filter rejects it.
    pub fn frame(&self, frame: &CanFrame, now_us: u64) -> Option<SlcanLine> {
        if self.state == ChannelState::Closed || !self.acceptance.accepts(frame) {
            return None;
        }
        let mut text = SlcanLine::EMPTY;
        text.put_frame(frame);
        match self.timestamps {
            Timestamps::None => {}
            Timestamps::Milliseconds => text.put_hex((now_us / 1000 % 60_000) as u32, 4),
            Timestamps::Microseconds => text.put_hex((now_us % 3_600_000_000) as u32, 8),
        }
        text.put(DONE);
        Some(text)
    }

    /// Reports that a line of [`Adapter::frame`] was lost because the serial line was full; `F`
    /// indicates it.
    pub fn line_lost(&mut self) {
        self.latched |= flags::RECEIVE_FULL;
    }

    /// The serial line is disconnected: closes the bus and resets the adapter.
    pub fn disconnect(&mut self, bus: &mut impl Bus) {
        if self.state != ChannelState::Closed {
            bus.close();
        }
        *self = Self::new(self.serial);
    }

    /// Executes a command; returns the answer, or `None` if the command is invalid.
    fn execute(&mut self, line: &[u8], bus: &mut impl Bus) -> Option<SlcanLine> {
        let Some((&command, rest)) = line.split_first() else {
            return Some(SlcanLine::of(DONE));
        };
        let is_closed = self.state == ChannelState::Closed;
        match (command, rest) {
            (b'S', [digit @ b'0'..=b'8']) if is_closed => {
                self.kbit_s = KBIT_S.get(usize::from(*digit - b'0')).copied();
            }
            (b'O' | b'L', []) if is_closed => return self.open(command == b'L', bus),
            (b'C', []) => {
                if !is_closed {
                    bus.close();
                }
                self.state = ChannelState::Closed;
            }
            (b't' | b'T' | b'r' | b'R', _) => return self.send(line, bus),
            (b'F', []) if !is_closed => {
                let mut text = SlcanLine::of(b"F");
                let latched = core::mem::take(&mut self.latched);
                text.put_hex(u32::from(bus.flags() | latched), 2);
                text.put(DONE);
                return Some(text);
            }
            (b'V', []) => return Some(SlcanLine::of(b"V1013\r")),
            (b'N', []) => {
                let mut text = SlcanLine::of(b"N");
                text.put(&self.serial);
                text.put(DONE);
                return Some(text);
            }
            (b'Z', [b'0']) => self.timestamps = Timestamps::None,
            (b'Z', [b'1']) => self.timestamps = Timestamps::Milliseconds,
            (b'Z', [b'2']) => self.timestamps = Timestamps::Microseconds,
            (b'M', number) if is_closed => self.acceptance.code = parse_word(number)?,
            (b'm', number) if is_closed => self.acceptance.mask = parse_word(number)?,
            _ => return None,
        }
        Some(SlcanLine::of(DONE))
    }

    fn open(&mut self, silent: bool, bus: &mut impl Bus) -> Option<SlcanLine> {
        bus.open(self.kbit_s, silent).then(|| {
            self.state = if silent {
                ChannelState::Silent
            } else {
                ChannelState::Open
            };
            self.latched = 0;
            SlcanLine::of(DONE)
        })
    }

    fn send(&mut self, line: &[u8], bus: &mut impl Bus) -> Option<SlcanLine> {
        let (frame, rest) = parse(line)?;
        if self.state != ChannelState::Open || !rest.is_empty() {
            return None;
        }
        if !bus.send(&frame) {
            self.latched |= flags::TRANSMIT_FULL;
            return None;
        }
        let (_, extended) = frame.raw_id();
        Some(SlcanLine::of(if extended { b"Z\r" } else { b"z\r" }))
    }
}

/// Parses exactly eight hexadecimal digits.
fn parse_word(text: &[u8]) -> Option<u32> {
    hex(text, 8)
        .filter(|(_, rest)| rest.is_empty())
        .map(|(number, _)| number)
}
