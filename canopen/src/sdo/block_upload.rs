//! Block upload (CiA 301, 7.2.4.3).

use super::{BUFFER, Data, Objects, State, Step, Upload, address, crc, expedited, reply};
use crate::Abort;

const LAST: u8 = 0x80;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    /// The size was answered; the client has to start.
    Begun,
    /// Segments go out.
    Sending,
    /// The block is out and has to be confirmed.
    Sent,
    /// All is confirmed and the end was sent.
    Ended,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct BlockUpload {
    upload: Upload,
    phase: Phase,
    checked: bool,
    crc: u16,
    /// Up to where `crc` goes: segments that are sent again do not count again.
    summed: u32,
    /// Where this block begins.
    confirmed: u32,
    /// Segments of this block that are out, of `block`.
    sequence: u8,
    block: u8,
}

impl BlockUpload {
    pub fn begin(request: &Data, buffer: &mut [u8; BUFFER], objects: &mut impl Objects) -> Step {
        let [command, _, _, _, block, threshold, ..] = *request;
        if !matches!(block, 1..=127) {
            return Err(Abort::BlockSize);
        }
        let upload = Upload::begin(address(request), buffer, objects)?;
        // The client would rather have so little in the other way (protocol switch threshold).
        if threshold != 0 && upload.size <= u32::from(threshold) {
            return expedited::answer_upload(upload, request, buffer, objects);
        }
        let transfer = Self {
            upload,
            phase: Phase::Begun,
            checked: command & 4 != 0,
            crc: 0,
            summed: 0,
            confirmed: 0,
            sequence: 0,
            block,
        };
        let answer = reply(0xC6, request, upload.size);
        Ok((State::BlockUpload(transfer), Some(answer)))
    }

    /// What the client says while the transfer is under way.
    pub fn answer(mut self, request: &Data) -> Step {
        match (request[0] & 3, self.phase) {
            (3, Phase::Begun) => self.phase = Phase::Sending,
            (2, Phase::Sending | Phase::Sent) => return self.confirm(request[1], request[2]),
            (1, Phase::Ended) => return Ok((State::Idle, None)),
            _ => return Err(Abort::Command),
        }
        Ok((State::BlockUpload(self), None))
    }

    fn confirm(mut self, sequence: u8, block: u8) -> Step {
        if sequence > self.sequence {
            return Err(Abort::SequenceNumber);
        }
        if !matches!(block, 1..=127) {
            return Err(Abort::BlockSize);
        }
        let all = self.phase == Phase::Sent && sequence == self.sequence;
        self.confirmed = self.offset(sequence);
        self.sequence = 0;
        self.block = block;
        self.phase = Phase::Sending;
        if !all || self.confirmed < self.upload.size {
            return Ok((State::BlockUpload(self), None));
        }
        self.phase = Phase::Ended;
        // The last segment carries 1 to 7 bytes, or none where there are none at all.
        let used = match self.upload.size {
            0 => 0,
            size => (size - 1) % 7 + 1,
        };
        let [low, high] = if self.checked { self.crc } else { 0 }.to_le_bytes();
        let command = 0xC1 | (7 - used as u8) << 2;
        Ok((
            State::BlockUpload(self),
            Some([command, low, high, 0, 0, 0, 0, 0]),
        ))
    }

    /// Where the data after so many segments of this block begin.
    fn offset(&self, sequence: u8) -> u32 {
        self.confirmed
            .saturating_add(u32::from(sequence) * 7)
            .min(self.upload.size)
    }

    /// The next segment, if one is to go out.
    pub fn next(
        &mut self,
        buffer: &[u8; BUFFER],
        objects: &mut impl Objects,
    ) -> Result<Option<Data>, Abort> {
        if self.phase != Phase::Sending {
            return Ok(None);
        }
        let mut segment = [0; 8];
        let [command, data @ ..] = &mut segment;
        let offset = self.offset(self.sequence);
        let length = self.upload.read(offset, data, buffer, objects)?;
        if self.checked && offset == self.summed {
            self.crc = crc::update(self.crc, data.get(..length).unwrap_or_default());
            self.summed = offset.saturating_add(length as u32);
        }
        self.sequence = self.sequence.saturating_add(1);
        let last = offset.saturating_add(length as u32) >= self.upload.size;
        *command = self.sequence | if last { LAST } else { 0 };
        if last || self.sequence >= self.block {
            self.phase = Phase::Sent;
        }
        Ok(Some(segment))
    }
}
