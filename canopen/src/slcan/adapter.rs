//! What stands between a serial line and a bus.

use super::line::{hex, parse};
use super::{Acceptance, KBIT_S, Text, flags};
use crate::CanFrame;

const DONE: &[u8] = b"\r";
const BELL: &[u8] = b"\x07";
/// Longer than any command.
const LINE: usize = 32;

/// The bus side of an [`Adapter`].
pub trait Bus {
    /// Goes on the bus at so many kbit/s, one of [`KBIT_S`], or without a wish where the client has none; only listens,
    /// without even acknowledging, if `silent`. Whether it can.
    fn open(&mut self, kbit_s: Option<u16>, silent: bool) -> bool;

    /// Leaves the bus.
    fn close(&mut self);

    /// Takes a frame to be sent; `false` where there is no room.
    fn send(&mut self, frame: &CanFrame) -> bool;

    /// State of the controller, and what happened since this was asked: bits of [`flags`].
    fn flags(&mut self) -> u8;
}

/// What a received frame carries of its time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Stamps {
    /// Nothing.
    #[default]
    None,
    /// Milliseconds, from 0 again after 59,999.
    Milliseconds,
    /// Microseconds, from 0 again after 3,599,999,999.
    Microseconds,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Closed,
    Open,
    Silent,
}

/// One adapter, as a client sees it.
#[derive(Clone, Debug)]
pub struct Adapter {
    serial: [u8; 4],
    state: State,
    kbit_s: Option<u16>,
    stamps: Stamps,
    acceptance: Acceptance,
    latched: u8,
    line: [u8; LINE],
    /// What has come of a line; beyond [`LINE`] the line is none.
    length: usize,
}

impl Adapter {
    /// A closed one, with its serial number of four letters or digits.
    #[must_use]
    pub const fn new(serial: [u8; 4]) -> Self {
        Self {
            serial,
            state: State::Closed,
            kbit_s: None,
            stamps: Stamps::None,
            acceptance: Acceptance {
                code: 0,
                mask: u32::MAX,
            },
            latched: 0,
            line: [0; LINE],
            length: 0,
        }
    }

    /// Takes a byte of the serial line; at the end of a command the answer.
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
    /// let mut said = Vec::new();
    /// for byte in b"O\rt1232AABB\rV\r" {
    ///     if let Some(text) = adapter.receive(*byte, &mut wire) {
    ///         said.extend_from_slice(text.as_bytes());
    ///     }
    /// }
    /// assert_eq!(said, b"\rz\rV1013\r");
    /// assert_eq!(wire.0.len(), 1);
    /// ```
    pub fn receive(&mut self, byte: u8, bus: &mut impl Bus) -> Option<Text> {
        // Some clients end a line with both.
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
        let answer = line.get(..length).and_then(|line| self.obey(line, bus));
        Some(answer.unwrap_or(Text::of(BELL)))
    }

    /// The line of a frame from the bus; `None` where the client does not hear it.
    pub fn frame(&self, frame: &CanFrame, now_us: u64) -> Option<Text> {
        if self.state == State::Closed || !self.acceptance.accepts(frame) {
            return None;
        }
        let mut text = Text::EMPTY;
        text.put_frame(frame);
        match self.stamps {
            Stamps::None => {}
            Stamps::Milliseconds => text.put_hex((now_us / 1000 % 60_000) as u32, 4),
            Stamps::Microseconds => text.put_hex((now_us % 3_600_000_000) as u32, 8),
        }
        text.put(DONE);
        Some(text)
    }

    /// A text of [`Adapter::frame`] was lost, as the serial line did not take it: `F` tells so.
    pub fn lost(&mut self) {
        self.latched |= flags::RECEIVE_FULL;
    }

    /// The serial line is gone: nobody is there to close the bus.
    pub fn hang_up(&mut self, bus: &mut impl Bus) {
        if self.state != State::Closed {
            bus.close();
        }
        *self = Self::new(self.serial);
    }

    /// The answer; `None` where it is not possible.
    fn obey(&mut self, line: &[u8], bus: &mut impl Bus) -> Option<Text> {
        let Some((&command, rest)) = line.split_first() else {
            return Some(Text::of(DONE));
        };
        let is_closed = self.state == State::Closed;
        match (command, rest) {
            (b'S', [digit @ b'0'..=b'8']) if is_closed => {
                self.kbit_s = KBIT_S.get(usize::from(*digit - b'0')).copied();
            }
            (b'O' | b'L', []) if is_closed => return self.open(command == b'L', bus),
            (b'C', []) => {
                if !is_closed {
                    bus.close();
                }
                self.state = State::Closed;
            }
            (b't' | b'T' | b'r' | b'R', _) => return self.send(line, bus),
            (b'F', []) if !is_closed => {
                let mut text = Text::of(b"F");
                let latched = core::mem::take(&mut self.latched);
                text.put_hex(u32::from(bus.flags() | latched), 2);
                text.put(DONE);
                return Some(text);
            }
            (b'V', []) => return Some(Text::of(b"V1013\r")),
            (b'N', []) => {
                let mut text = Text::of(b"N");
                text.put(&self.serial);
                text.put(DONE);
                return Some(text);
            }
            (b'Z', [b'0']) => self.stamps = Stamps::None,
            (b'Z', [b'1']) => self.stamps = Stamps::Milliseconds,
            (b'Z', [b'2']) => self.stamps = Stamps::Microseconds,
            (b'M', number) if is_closed => self.acceptance.code = whole(number)?,
            (b'm', number) if is_closed => self.acceptance.mask = whole(number)?,
            _ => return None,
        }
        Some(Text::of(DONE))
    }

    fn open(&mut self, silent: bool, bus: &mut impl Bus) -> Option<Text> {
        bus.open(self.kbit_s, silent).then(|| {
            self.state = if silent { State::Silent } else { State::Open };
            self.latched = 0;
            Text::of(DONE)
        })
    }

    fn send(&mut self, line: &[u8], bus: &mut impl Bus) -> Option<Text> {
        let (frame, rest) = parse(line)?;
        if self.state != State::Open || !rest.is_empty() {
            return None;
        }
        if !bus.send(&frame) {
            self.latched |= flags::TRANSMIT_FULL;
            return None;
        }
        let (_, extended) = frame.raw_id();
        Some(Text::of(if extended { b"Z\r" } else { b"z\r" }))
    }
}

/// Eight hexadecimal digits and nothing more.
fn whole(text: &[u8]) -> Option<u32> {
    hex(text, 8)
        .filter(|(_, rest)| rest.is_empty())
        .map(|(number, _)| number)
}
