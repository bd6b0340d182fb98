//! SDO block download (CiA 301, 7.2.4.3): up to 127 segments per confirmation.

use super::{Data, ObjectAccess, SdoServer, Transfer, TransferState, crc, word};
use crate::Abort;

/// Block size. Segments are not buffered, so the maximum is used.
const BLOCK: u8 = 127;
const LAST: u8 = 0x80;

impl SdoServer {
    pub(super) fn begin_block_download(
        &mut self,
        request: &Data,
        objects: &mut impl ObjectAccess,
    ) -> Result<(), Abort> {
        let announced = (request[0] & 2 != 0).then(|| word(request));
        self.begin_download(TransferState::BlockDownload, announced, objects)?;
        self.transfer.uses_crc = request[0] & 4 != 0;
        self.answer_with_object(0xA4, u32::from(BLOCK));
        Ok(())
    }

    pub(super) fn block_segment(
        &mut self,
        request: &Data,
        objects: &mut impl ObjectAccess,
    ) -> Result<(), Abort> {
        let [command, data @ ..] = request;
        let (sequence, last) = (command & !LAST, command & LAST != 0);
        if sequence == 0 {
            return Err(Abort::SequenceNumber);
        }
        // After a gap the rest of the block is ignored: the client repeats all unconfirmed
        // segments.
        if sequence == self.transfer.sequence + 1 {
            self.transfer.sequence = sequence;
            if last {
                self.transfer.last = *data;
                self.state = TransferState::BlockDownloaded;
            } else {
                self.receive_block_data(data, objects)?;
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
        objects: &mut impl ObjectAccess,
    ) -> Result<(), Abort> {
        let [command, low, high, ..] = *request;
        let last = self.transfer.last;
        let unused = usize::from(command >> 2 & 7);
        self.receive_block_data(last.get(..7 - unused).unwrap_or_default(), objects)?;
        let Transfer { uses_crc, crc, .. } = self.transfer;
        if uses_crc && crc != u16::from_le_bytes([low, high]) {
            return Err(Abort::Crc);
        }
        self.answer([0xA1, 0, 0, 0], 0);
        self.finish(objects)
    }

    fn receive_block_data(
        &mut self,
        data: &[u8],
        objects: &mut impl ObjectAccess,
    ) -> Result<(), Abort> {
        if self.transfer.uses_crc {
            self.transfer.crc = crc::update(self.transfer.crc, data);
        }
        self.receive_data(data, objects)
    }
}
