//! Block download (CiA 301, 7.2.4.3): up to 127 segments are confirmed at once.

use super::{Data, Objects, Server, State, Transfer, crc, word};
use crate::Abort;

/// Segments in a block: nothing is kept of a block, so that it can have as many as there may be.
const BLOCK: u8 = 127;
const LAST: u8 = 0x80;

impl Server {
    pub(super) fn begin_block_download(
        &mut self,
        request: &Data,
        objects: &mut impl Objects,
    ) -> Result<(), Abort> {
        let announced = (request[0] & 2 != 0).then(|| word(request));
        self.begin_download(State::BlockDownload, announced, objects)?;
        self.transfer.checked = request[0] & 4 != 0;
        self.answer_of_object(0xA4, u32::from(BLOCK));
        Ok(())
    }

    pub(super) fn block_segment(
        &mut self,
        request: &Data,
        objects: &mut impl Objects,
    ) -> Result<(), Abort> {
        let [command, data @ ..] = request;
        let (sequence, last) = (command & !LAST, command & LAST != 0);
        if sequence == 0 {
            return Err(Abort::SequenceNumber);
        }
        // After a gap the rest of the block is lost: the client sends again what is not confirmed.
        if sequence == self.transfer.sequence + 1 {
            self.transfer.sequence = sequence;
            if last {
                self.transfer.last = *data;
                self.state = State::BlockDownloaded;
            } else {
                self.take_checked(data, objects)?;
            }
        }
        if sequence >= BLOCK || last {
            let confirmed = core::mem::take(&mut self.transfer.sequence);
            self.answer([0xA2, confirmed, BLOCK, 0], 0);
        }
        Ok(())
    }

    pub(super) fn end_block_download(
        &mut self,
        request: &Data,
        objects: &mut impl Objects,
    ) -> Result<(), Abort> {
        let [command, low, high, ..] = *request;
        let last = self.transfer.last;
        let unused = usize::from(command >> 2 & 7);
        self.take_checked(last.get(..7 - unused).unwrap_or_default(), objects)?;
        let Transfer { checked, crc, .. } = self.transfer;
        if checked && crc != u16::from_le_bytes([low, high]) {
            return Err(Abort::Crc);
        }
        self.answer([0xA1, 0, 0, 0], 0);
        self.finish(objects)
    }

    fn take_checked(&mut self, data: &[u8], objects: &mut impl Objects) -> Result<(), Abort> {
        if self.transfer.checked {
            self.transfer.crc = crc::update(self.transfer.crc, data);
        }
        self.take(data, objects)
    }
}
