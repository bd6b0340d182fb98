//! SDO block upload (CiA 301, 7.2.4.3).

use super::{Data, ObjectAccess, SdoServer, TransferState, crc};
use crate::Abort;

const LAST: u8 = 0x80;

impl SdoServer {
    pub(super) fn begin_block_upload(
        &mut self,
        request: &Data,
        objects: &mut impl ObjectAccess,
    ) -> Result<(), Abort> {
        let [command, _, _, _, block, threshold, ..] = *request;
        self.set_block(block)?;
        let size = self.begin_upload(objects)?;
        // At or below the protocol switch threshold the server answers with a normal upload.
        if threshold != 0 && size <= u32::from(threshold) {
            return self.answer_upload(objects);
        }
        self.transfer.uses_crc = command & 4 != 0;
        self.state = TransferState::BlockUpload;
        self.answer_with_object(0xC6, size);
        Ok(())
    }

    fn set_block(&mut self, block: u8) -> Result<(), Abort> {
        if !matches!(block, 1..=127) {
            return Err(Abort::BlockSize);
        }
        self.transfer.block = block;
        Ok(())
    }

    /// Processes a request of the client during the transfer.
    pub(super) fn continue_block_upload(&mut self, request: &Data) -> Result<(), Abort> {
        match (request[0] & 3, self.state) {
            (3, TransferState::BlockUpload) => self.state = TransferState::BlockSending,
            (2, TransferState::BlockSending | TransferState::BlockSent) => {
                return self.confirm(request[1], request[2]);
            }
            (1, TransferState::BlockUploaded) => self.state = TransferState::Idle,
            _ => return Err(Abort::Command),
        }
        Ok(())
    }

    fn confirm(&mut self, sequence: u8, block: u8) -> Result<(), Abort> {
        if sequence > self.transfer.sequence {
            return Err(Abort::SequenceNumber);
        }
        self.set_block(block)?;
        let all = self.state == TransferState::BlockSent && sequence == self.transfer.sequence;
        self.transfer.offset = self.position(sequence);
        self.transfer.sequence = 0;
        self.state = TransferState::BlockSending;
        let size = self.size();
        if !all || self.transfer.offset < size {
            return Ok(());
        }
        self.state = TransferState::BlockUploaded;
        // The last segment carries 1 to 7 bytes, or none if the size is 0.
        let used = match size {
            0 => 0,
            size => (size - 1) % 7 + 1,
        };
        let [low, high] = self.transfer.crc.to_le_bytes();
        self.answer([0xC1 | (7 - used as u8) << 2, low, high, 0], 0);
        Ok(())
    }

    /// Byte offset after `sequence` segments of this block.
    fn position(&self, sequence: u8) -> u32 {
        let position = (self.transfer.offset).saturating_add(u32::from(sequence) * 7);
        position.min(self.size())
    }

    /// Transmits the next segment.
    pub(super) fn send_segment(&mut self, objects: &mut impl ObjectAccess) -> Result<(), Abort> {
        let mut segment = [0; 8];
        let [command, data @ ..] = &mut segment;
        let offset = self.position(self.transfer.sequence);
        let (length, last) = self.read(offset, data, objects)?;
        let transfer = &mut self.transfer;
        if transfer.uses_crc && offset == transfer.crc_offset {
            transfer.crc = crc::update(transfer.crc, data.get(..length).unwrap_or_default());
            transfer.crc_offset += length as u32;
        }
        transfer.sequence += 1;
        *command = transfer.sequence | if last { LAST } else { 0 };
        if last || transfer.sequence >= transfer.block {
            self.state = TransferState::BlockSent;
        }
        self.reply = Some(segment);
        Ok(())
    }
}
