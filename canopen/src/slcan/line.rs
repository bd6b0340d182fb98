//! Conversion between CAN frames and lines.

use embedded_can::Frame;

use crate::CanFrame;
use crate::message::copy;

/// Longest line: `T`, identifier, length, eight data bytes, timestamp and CR.
const LINE_LENGTH_MAX: usize = 36;

/// A line of the protocol.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SlcanLine {
    bytes: [u8; LINE_LENGTH_MAX],
    length: u8,
}

impl SlcanLine {
    pub(super) const EMPTY: Self = Self {
        bytes: [0; LINE_LENGTH_MAX],
        length: 0,
    };

    /// The bytes.
    #[must_use]
    pub fn as_bytes(&self) -> &[u8] {
        self.bytes
            .get(..usize::from(self.length))
            .unwrap_or(&self.bytes)
    }

    /// The line of a frame, including CR.
    ///
    /// ```
    /// use canopen::{CanFrame, slcan::SlcanLine};
    /// let frame = CanFrame::raw(0x605, false, false, 2, [0x40, 0xAB, 0, 0, 0, 0, 0, 0]).unwrap();
    /// assert_eq!(SlcanLine::frame(&frame).as_bytes(), b"t605240AB\r");
    /// ```
    #[must_use]
    pub fn frame(frame: &CanFrame) -> Self {
        let mut text = Self::EMPTY;
        text.put_frame(frame);
        text.put(b"\r");
        text
    }

    pub(super) fn of(bytes: &[u8]) -> Self {
        let mut text = Self::EMPTY;
        text.put(bytes);
        text
    }

    pub(super) fn put(&mut self, bytes: &[u8]) {
        if let Some(rest) = self.bytes.get_mut(usize::from(self.length)..) {
            self.length += copy(rest, bytes) as u8;
        }
    }

    /// The last `digits` hexadecimal digits of a number.
    pub(super) fn put_hex(&mut self, number: u32, digits: u32) {
        for digit in (0..digits).rev() {
            let value = (number.checked_shr(4 * digit).unwrap_or(0) & 15) as u8;
            let first = if value < 10 { b'0' } else { b'A' - 10 };
            self.put(&[first + value]);
        }
    }

    pub(super) fn put_frame(&mut self, frame: &CanFrame) {
        let (id, extended) = frame.raw_id();
        let (kind, digits) = match (extended, frame.is_remote_frame()) {
            (false, false) => (b't', 3),
            (true, false) => (b'T', 8),
            (false, true) => (b'r', 3),
            (true, true) => (b'R', 8),
        };
        self.put(&[kind]);
        self.put_hex(id, digits);
        self.put_hex(frame.dlc() as u32, 1);
        for byte in frame.data() {
            self.put_hex(u32::from(*byte), 2);
        }
    }
}

/// Parses the frame of a line such as `t6058402F600001000000`, without CR; `None` if it is invalid.
/// Characters after the frame, such as a timestamp, are ignored.
///
/// ```
/// use canopen::slcan::parse_frame;
/// let frame = parse_frame(b"R1234567830042").unwrap();
/// assert_eq!((frame.raw_id(), frame.bytes()), ((0x1234_5678, true), [0; 8]));
/// assert_eq!(parse_frame(b"t8000"), None, "more than 11 bits");
/// assert_eq!(parse_frame(b"t1232AB"), None, "a byte is missing");
/// ```
#[must_use]
pub fn parse_frame(line: &[u8]) -> Option<CanFrame> {
    parse(line).map(|(frame, _)| frame)
}

/// The frame of a line, and the rest of the line.
pub(super) fn parse(line: &[u8]) -> Option<(CanFrame, &[u8])> {
    let (&kind, rest) = line.split_first()?;
    let (extended, remote) = match kind {
        b't' => (false, false),
        b'T' => (true, false),
        b'r' => (false, true),
        b'R' => (true, true),
        _ => return None,
    };
    let (id, rest) = hex(rest, if extended { 8 } else { 3 })?;
    let (length, mut rest) = hex(rest, 1)?;
    let length = u8::try_from(length).ok().filter(|length| *length <= 8)?;
    let mut data = [0; 8];
    if !remote {
        for byte in data.iter_mut().take(usize::from(length)) {
            let value;
            (value, rest) = hex(rest, 2)?;
            *byte = value as u8;
        }
    }
    Some((CanFrame::raw(id, extended, remote, length, data)?, rest))
}

/// A number of `digits` hexadecimal digits, at most eight, and the rest of the line.
pub(super) fn hex(text: &[u8], digits: usize) -> Option<(u32, &[u8])> {
    let (number, rest) = text.split_at_checked(digits)?;
    let number = number.iter().try_fold(0, |number: u32, digit| {
        let value = char::from(*digit).to_digit(16)?;
        Some(number << 4 | value)
    })?;
    Some((number, rest))
}
