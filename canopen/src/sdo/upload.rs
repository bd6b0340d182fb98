//! Common part of all uploads: reads the data from their source.

use super::{BUFFER, DataLocation, ObjectAccess, SdoServer};
use crate::Abort;
use crate::dictionary::DataType;
use crate::message::copy;

impl SdoServer {
    /// Begins an upload; returns its size in bytes.
    pub(super) fn begin_upload(&mut self, objects: &mut impl ObjectAccess) -> Result<u32, Abort> {
        let transfer = &mut self.transfer;
        let entry = objects.entry(transfer.address)?;
        if !entry.is_readable() {
            return Err(Abort::WriteOnly);
        }
        let size = if entry.data_type() == DataType::Domain {
            transfer.location = DataLocation::Domain;
            objects.domain_size(transfer.address)?
        } else if let Some(text) = objects.constant_text(entry) {
            transfer.location = DataLocation::Text(text);
            text.len() as u32
        } else {
            objects.read(entry, &mut self.buffer)?.min(BUFFER) as u32
        };
        transfer.size = Some(size);
        Ok(size)
    }

    /// Reads up to seven bytes from `offset`; returns their number and whether they are the last.
    pub(super) fn read(
        &self,
        offset: u32,
        to: &mut [u8],
        objects: &mut impl ObjectAccess,
    ) -> Result<(usize, bool), Abort> {
        let rest = self.size().saturating_sub(offset) as usize;
        let length = rest.min(to.len());
        let to = to.get_mut(..length).unwrap_or_default();
        let all: &[u8] = match self.transfer.location {
            DataLocation::Buffer => &self.buffer,
            DataLocation::Text(text) => text,
            DataLocation::Domain => &[],
        };
        if self.transfer.location != DataLocation::Domain {
            copy(to, all.get(offset as usize..).unwrap_or_default());
        } else if length != 0 {
            objects.domain_read(self.transfer.address, offset, to)?;
        }
        Ok((length, length == rest))
    }

    /// Size of the upload in bytes.
    pub(super) fn size(&self) -> u32 {
        self.transfer.size.unwrap_or(0)
    }
}
