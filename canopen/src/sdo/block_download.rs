//! Block download (CiA 301, 7.2.4.3): up to 127 segments are confirmed at once.

use super::{BUFFER, Data, Download, Objects, State, Step, address, crc, reply, word};
use crate::Abort;

/// Segments in a block: nothing is kept of a block, so that it can have as many as there may be.
const BLOCK: u8 = 127;
const LAST: u8 = 0x80;

#[derive(Clone, Copy, Debug)]
pub(super) struct BlockDownload {
    pub download: Download,
    checked: bool,
    crc: u16,
    /// Segments of this block that came in order.
    sequence: u8,
    /// The last segment of the transfer, of which only the end tells how much is data.
    last: Option<[u8; 7]>,
    /// The last segment has been confirmed.
    ended: bool,
}

impl BlockDownload {
    pub fn begin(request: &Data, objects: &mut impl Objects) -> Step {
        let announced = (request[0] & 2 != 0).then(|| word(request));
        let download = Download::begin(address(request), announced, objects)?;
        let checked = request[0] & 4 != 0;
        let transfer = Self {
            download,
            checked,
            crc: 0,
            sequence: 0,
            last: None,
            ended: false,
        };
        let answer = reply(0xA4, request, u32::from(BLOCK));
        Ok((State::BlockDownload(transfer), Some(answer)))
    }

    /// Whether the next frame is a segment.
    pub const fn takes_segments(&self) -> bool {
        !self.ended
    }

    pub fn segment(
        mut self,
        request: &Data,
        buffer: &mut [u8; BUFFER],
        objects: &mut impl Objects,
    ) -> Step {
        let [command, data @ ..] = request;
        let sequence = command & !LAST;
        if sequence == 0 {
            return Err(Abort::SequenceNumber);
        }
        // After a gap the rest of the block is lost: the client sends again what is not confirmed.
        if sequence == self.sequence + 1 {
            self.sequence = sequence;
            if command & LAST == 0 {
                self.take(data, buffer, objects)?;
            } else {
                self.last = Some(*data);
                self.ended = true;
            }
        }
        if sequence < BLOCK && command & LAST == 0 {
            return Ok((State::BlockDownload(self), None));
        }
        let confirmed = core::mem::take(&mut self.sequence);
        Ok((
            State::BlockDownload(self),
            Some([0xA2, confirmed, BLOCK, 0, 0, 0, 0, 0]),
        ))
    }

    pub fn end(
        mut self,
        request: &Data,
        buffer: &mut [u8; BUFFER],
        objects: &mut impl Objects,
    ) -> Step {
        let [command, low, high, ..] = request;
        let unused = usize::from(command >> 2 & 7);
        if let Some(last) = self.last {
            self.take(last.get(..7 - unused).unwrap_or_default(), buffer, objects)?;
        }
        if self.checked && self.crc != u16::from_le_bytes([*low, *high]) {
            return Err(Abort::Crc);
        }
        self.download
            .finish([0xA1, 0, 0, 0, 0, 0, 0, 0], buffer, objects)
    }

    fn take(
        &mut self,
        data: &[u8],
        buffer: &mut [u8; BUFFER],
        objects: &mut impl Objects,
    ) -> Result<(), Abort> {
        if self.checked {
            self.crc = crc::update(self.crc, data);
        }
        self.download.take(data, buffer, objects)
    }
}
