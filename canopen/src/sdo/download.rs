//! Common part of all downloads: collects the data and writes the object.

use core::task::Poll;

use super::{DataLocation, ObjectAccess, SdoServer, TransferState};
use crate::Abort;
use crate::dictionary::DataType;
use crate::message::copy;

impl SdoServer {
    /// Begins a download and enters `state`.
    pub(super) fn begin_download(
        &mut self,
        state: TransferState,
        announced: Option<u32>,
        objects: &mut impl ObjectAccess,
    ) -> Result<(), Abort> {
        let transfer = &mut self.transfer;
        let entry = objects.entry(transfer.address)?;
        objects.check_write(entry, announced)?;
        if entry.data_type() == DataType::Domain {
            objects.domain_begin(transfer.address, announced)?;
            transfer.location = DataLocation::Domain;
        }
        transfer.size = announced;
        self.state = state;
        Ok(())
    }

    /// Receives the next bytes.
    pub(super) fn receive_data(
        &mut self,
        data: &[u8],
        objects: &mut impl ObjectAccess,
    ) -> Result<(), Abort> {
        let transfer = &mut self.transfer;
        let offset = transfer.offset;
        let received = offset
            .checked_add(data.len() as u32)
            .ok_or(Abort::TooLong)?;
        if transfer.size.is_some_and(|size| received > size) {
            return Err(Abort::TooLong);
        }
        if transfer.location == DataLocation::Domain {
            objects.domain_write(transfer.address, offset, data)?;
        } else {
            let room = self.buffer.get_mut(offset as usize..).unwrap_or_default();
            if copy(room, data) < data.len() {
                return Err(Abort::TooLong);
            }
        }
        transfer.offset = received;
        Ok(())
    }

    /// Writes the object after all data are received; while the application is busy, the reply is
    /// withheld.
    pub(super) fn finish(&mut self, objects: &mut impl ObjectAccess) -> Result<(), Abort> {
        let transfer = &self.transfer;
        let received = transfer.offset;
        if transfer.size.is_some_and(|size| received < size) {
            return Err(Abort::TooShort);
        }
        let done = if transfer.location == DataLocation::Domain {
            objects.domain_end(transfer.address, received)
        } else {
            let entry = objects.entry(transfer.address)?;
            objects.check_write(entry, Some(received))?;
            let data = self.buffer.get(..received as usize);
            objects.write(entry, data.ok_or(Abort::TooLong)?)
        };
        self.state = match done {
            Poll::Ready(done) => done.map(|()| TransferState::Idle)?,
            Poll::Pending => TransferState::Finishing,
        };
        Ok(())
    }
}
