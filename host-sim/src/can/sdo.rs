//! An SDO client: expedited, segmented, and block upload for long data.

use std::io;
use std::time::{Duration, Instant};

use canopen::{Abort, CanFrame, cob_id};
use embedded_can::Frame;

use super::link::Link;
use super::names;

/// Why a transfer failed.
#[derive(Debug, thiserror::Error)]
pub enum SdoError {
    /// The bus failed.
    #[error("the bus: {0}")]
    Link(#[from] io::Error),
    /// The node does not answer.
    #[error("node {0} does not answer")]
    Timeout(u8),
    /// The node aborts the transfer.
    #[error("{index:04X}h:{sub}: {}", abort_text(*code))]
    Abort {
        /// Index of the object.
        index: u16,
        /// Sub-index.
        sub: u8,
        /// Abort code.
        code: u32,
    },
    /// The node violates the protocol.
    #[error("node {0} violates the SDO protocol")]
    Protocol(u8),
}

impl SdoError {
    /// The limits that the value has exceeded, after a comma; empty for another error, and for a
    /// value that other values limit.
    pub fn expected(&self) -> String {
        let Self::Abort { index, sub, code } = self else {
            return String::new();
        };
        let is_of_limits = [Abort::TooHigh, Abort::TooLow].map(Abort::code);
        names::rows()
            .iter()
            .find(|row| row.address() == (*index, *sub))
            .filter(|row| is_of_limits.contains(code) && row.relation.is_none())
            .and_then(|row| Some((row, row.limits.as_ref()?)))
            .map_or(String::new(), |(row, (least, most))| {
                let text = format!(", expected {least} to {most} {}", row.unit);
                text.trim_end().to_owned()
            })
    }
}

/// The text of an abort code.
pub fn abort_text(code: u32) -> String {
    let known: [(Abort, &str); 15] = [
        (Abort::NoObject, "there is no such object"),
        (Abort::NoSubIndex, "there is no such sub-index"),
        (Abort::ReadOnly, "the object is read only"),
        (Abort::WriteOnly, "the object is write only"),
        (Abort::TooLong, "the value has too many bytes"),
        (Abort::TooShort, "the value has too few bytes"),
        (Abort::TooHigh, "the value is too high"),
        (Abort::TooLow, "the value is too low"),
        (Abort::Value, "the value is invalid"),
        (Abort::Incompatible, "the value conflicts with another one"),
        (
            Abort::MaximumBelowMinimum,
            "the maximum would be below the minimum",
        ),
        (
            Abort::DeviceState,
            "not possible in the present state of the device: it is enabled, has no power, is \
             locked by its service password, or lacks what this needs",
        ),
        (Abort::NoData, "there is no data"),
        (Abort::Hardware, "the hardware failed"),
        (Abort::Store, "the value cannot be stored"),
    ];
    let text = known.iter().find(|(abort, _)| abort.code() == code);
    let text = text.map_or("refused", |(_, text)| text);
    format!("{text} (abort code {code:08X}h)")
}

/// An SDO client of one node.
pub struct Sdo<'a> {
    link: &'a mut dyn Link,
    node: u8,
}

/// The response timeout: a node may have to erase flash, for up to 4 s.
const TIMEOUT: Duration = Duration::from_secs(5);

/// Blocks of which no segment arrives before a download is given up.
const REPETITIONS: u32 = 5;

/// Segments of a block, the most that the protocol allows.
const BLOCK: u8 = 127;

impl<'a> Sdo<'a> {
    /// A client of this node.
    pub fn new(link: &'a mut dyn Link, node: u8) -> Self {
        Self { link, node }
    }

    fn send(&mut self, data: [u8; 8]) -> Result<(), SdoError> {
        let id = cob_id::of_node(cob_id::SDO_REQUEST, self.node);
        let frame = CanFrame::received(id.into(), false, 8, data);
        Ok(self.link.send(&frame)?)
    }

    /// Ends a transfer of this object that an earlier client has left, which would take the next
    /// request for a segment until its time-out of a second.
    ///
    /// # Errors
    /// [`SdoError::Link`].
    pub fn abort(&mut self, index: u16, sub: u8) -> Result<(), SdoError> {
        let [low, high] = index.to_le_bytes();
        let [a, b, c, d] = Abort::Timeout.code().to_le_bytes();
        self.send([0x80, low, high, sub, a, b, c, d])
    }

    fn response(&mut self) -> Result<[u8; 8], SdoError> {
        let end = Instant::now() + TIMEOUT;
        loop {
            let left = end.saturating_duration_since(Instant::now());
            let Some(frame) = self.link.receive(left)? else {
                return Err(SdoError::Timeout(self.node));
            };
            if frame.raw_id() == (cob_id::SDO_RESPONSE + u32::from(self.node), false)
                && frame.dlc() == 8
            {
                return Ok(frame.bytes());
            }
        }
    }

    /// Sends the first request of a transfer and returns the response. Responses about other
    /// objects, and to another kind of request, are skipped: they are for other clients of the
    /// node.
    fn begin(
        &mut self,
        command: u8,
        data: [u8; 4],
        (index, sub): (u16, u8),
    ) -> Result<[u8; 8], SdoError> {
        let ([low, high], [a, b, c, d]) = (index.to_le_bytes(), data);
        self.send([command, low, high, sub, a, b, c, d])?;
        loop {
            let response = self.response()?;
            let is_own = is_response_to(command, response[0]);
            if is_own && response[1..4] == [low, high, sub] {
                return check_abort(response, (index, sub));
            }
        }
    }

    /// Sends a further request and returns the response.
    fn request(&mut self, request: [u8; 8], object: (u16, u8)) -> Result<[u8; 8], SdoError> {
        self.send(request)?;
        check_abort(self.response()?, object)
    }

    /// The value of an object.
    ///
    /// # Errors
    /// [`SdoError`].
    pub fn upload(&mut self, index: u16, sub: u8) -> Result<Vec<u8>, SdoError> {
        let response = self.begin(0x40, [0; 4], (index, sub))?;
        let [command, _, _, _, data @ ..] = response;
        match command {
            0x42 => Ok(data.to_vec()),
            0x43 | 0x47 | 0x4B | 0x4F => {
                let unused = usize::from(command >> 2 & 3);
                Ok(data[..4 - unused].to_vec())
            }
            0x40 | 0x41 => self.segments(index, sub),
            _ => Err(SdoError::Protocol(self.node)),
        }
    }

    fn segments(&mut self, index: u16, sub: u8) -> Result<Vec<u8>, SdoError> {
        let mut data = Vec::new();
        let mut toggle = 0;
        loop {
            let response = self.request([0x60 | toggle, 0, 0, 0, 0, 0, 0, 0], (index, sub))?;
            if response[0] & 0xF0 != toggle {
                return Err(SdoError::Protocol(self.node));
            }
            let unused = usize::from(response[0] >> 1 & 7);
            data.extend_from_slice(&response[1..8 - unused]);
            if response[0] & 1 != 0 {
                return Ok(data);
            }
            toggle ^= 0x10;
        }
    }

    /// The value of an object, by block transfer.
    ///
    /// # Errors
    /// [`SdoError`].
    pub fn upload_block(&mut self, index: u16, sub: u8) -> Result<Vec<u8>, SdoError> {
        let response = self.begin(0xA0, [BLOCK, 0, 0, 0], (index, sub))?;
        if response[0] & 0xE1 != 0xC0 {
            return Err(SdoError::Protocol(self.node));
        }
        self.send([0xA3, 0, 0, 0, 0, 0, 0, 0])?;
        let mut data = Vec::new();
        loop {
            let is_last = self.block(&mut data, (index, sub))?;
            if is_last {
                break;
            }
        }
        let end = self.response()?;
        if end[0] & 0xE3 != 0xC1 {
            return Err(SdoError::Protocol(self.node));
        }
        self.send([0xA1, 0, 0, 0, 0, 0, 0, 0])?;
        data.truncate(data.len() - usize::from(end[0] >> 2 & 7));
        Ok(data)
    }

    /// Receives one block; returns whether it was the last.
    fn block(&mut self, data: &mut Vec<u8>, (index, sub): (u16, u8)) -> Result<bool, SdoError> {
        let mut received = 0;
        let mut is_last = false;
        for number in 1..=BLOCK {
            let segment = check_abort(self.response()?, (index, sub))?;
            // Segments after a lost one are sent again with the next block.
            if segment[0] & 0x7F == number && received + 1 == number {
                received = number;
                data.extend_from_slice(&segment[1..]);
                is_last = segment[0] & 0x80 != 0;
            }
            if segment[0] & 0x80 != 0 || segment[0] & 0x7F == BLOCK {
                break;
            }
        }
        self.send([0xA2, received, BLOCK, 0, 0, 0, 0, 0])?;
        Ok(is_last)
    }

    /// Writes an object.
    ///
    /// # Errors
    /// [`SdoError`].
    pub fn download(&mut self, index: u16, sub: u8, value: &[u8]) -> Result<(), SdoError> {
        if let 1..=4 = value.len() {
            let mut data = [0; 4];
            data[..value.len()].copy_from_slice(value);
            let command = 0x23 | (4 - value.len() as u8) << 2;
            let response = self.begin(command, data, (index, sub))?;
            return self.expect(response[0] == 0x60);
        }
        let size = (value.len() as u32).to_le_bytes();
        let response = self.begin(0x21, size, (index, sub))?;
        self.expect(response[0] == 0x60)?;
        let mut toggle = 0;
        let mut rest = value;
        loop {
            let (now, later) = rest.split_at(rest.len().min(7));
            let mut segment = [0; 8];
            segment[0] = toggle | (7 - now.len() as u8) << 1 | u8::from(later.is_empty());
            segment[1..=now.len()].copy_from_slice(now);
            let response = self.request(segment, (index, sub))?;
            self.expect(response[0] == 0x20 | toggle)?;
            if later.is_empty() {
                return Ok(());
            }
            (toggle, rest) = (toggle ^ 0x10, later);
        }
    }

    /// Writes a long object by block transfer; `progress` receives how many bytes the node has
    /// confirmed. Segments that the node has lost are sent again.
    ///
    /// # Errors
    /// [`SdoError`].
    pub fn download_block(
        &mut self,
        (index, sub): (u16, u8),
        value: &[u8],
        progress: &mut dyn FnMut(usize),
    ) -> Result<(), SdoError> {
        let size = (value.len() as u32).to_le_bytes();
        // With a CRC, and the size.
        let begun = self.begin(0xC6, size, (index, sub))?;
        self.expect(begun[0] & 0xFB == 0xA0)?;
        let (has_crc, mut block) = (begun[0] & 4 != 0, begun[4]);
        let mut confirmed = 0;
        let mut repetitions = 0;
        while confirmed < value.len() {
            let sent = self.send_block(&value[confirmed..], block)?;
            let answer = check_abort(self.response()?, (index, sub))?;
            self.expect(answer[0] == 0xA2 && usize::from(answer[1]) <= sent)?;
            repetitions = if answer[1] == 0 { repetitions + 1 } else { 0 };
            self.expect(repetitions < REPETITIONS)?;
            confirmed = (confirmed + 7 * usize::from(answer[1])).min(value.len());
            block = answer[2];
            progress(confirmed);
        }
        let unused = (value.len().div_ceil(7) * 7 - value.len()) as u8;
        let crc = if has_crc { crc_16(value) } else { 0 };
        let [low, high] = crc.to_le_bytes();
        let end = [0xC1 | unused << 2, low, high, 0, 0, 0, 0, 0];
        let answer = self.request(end, (index, sub))?;
        self.expect(answer[0] == 0xA1)
    }

    /// Sends a block of at most so many segments; returns their number.
    fn send_block(&mut self, rest: &[u8], block: u8) -> Result<usize, SdoError> {
        let segments = rest.chunks(7).take(usize::from(block));
        let (sent, total) = (segments.len(), rest.len().div_ceil(7));
        for (number, bytes) in segments.enumerate() {
            let mut segment = [0; 8];
            let is_last = number + 1 == total;
            segment[0] = (number as u8 + 1) | if is_last { 0x80 } else { 0 };
            segment[1..=bytes.len()].copy_from_slice(bytes);
            self.send(segment)?;
        }
        Ok(sent)
    }

    fn expect(&self, is_valid: bool) -> Result<(), SdoError> {
        is_valid.then_some(()).ok_or(SdoError::Protocol(self.node))
    }
}

/// Whether a server responds to a first request with this command in this way, or with an abort.
fn is_response_to(request: u8, response: u8) -> bool {
    const ABORT: u8 = 4;
    let expected = match request >> 5 {
        // Download, upload, block download, and block upload.
        1 => 3,
        2 => 2,
        6 => 5,
        _ => 6,
    };
    let service = response >> 5;
    service == expected || service == ABORT
}

/// CRC of a block transfer (CiA 301, 7.2.4.3.16).
fn crc_16(data: &[u8]) -> u16 {
    data.iter().fold(0, |crc, byte| {
        (0..8).fold(crc ^ u16::from(*byte) << 8, |crc, _| {
            let carry = crc & 0x8000 != 0;
            crc << 1 ^ if carry { 0x1021 } else { 0 }
        })
    })
}

/// The response, unless it is an abort.
fn check_abort(response: [u8; 8], (index, sub): (u16, u8)) -> Result<[u8; 8], SdoError> {
    let [command, _, _, _, a, b, c, d] = response;
    if command == 0x80 {
        let code = u32::from_le_bytes([a, b, c, d]);
        return Err(SdoError::Abort { index, sub, code });
    }
    Ok(response)
}
