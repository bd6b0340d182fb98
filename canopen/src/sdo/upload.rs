//! What all uploads have in common: where the data come from.

use super::{BUFFER, Objects, Place, Server};
use crate::Abort;
use crate::dictionary::DataType;
use crate::message::copy;

impl Server {
    /// Begins an upload; how many bytes it has.
    pub(super) fn begin_upload(&mut self, objects: &mut impl Objects) -> Result<u32, Abort> {
        let transfer = &mut self.transfer;
        let row = objects.entry(transfer.address)?;
        if !row.readable() {
            return Err(Abort::WriteOnly);
        }
        let size = if row.data_type() == DataType::Domain {
            transfer.place = Place::Domain;
            objects.domain_size(transfer.address)?
        } else if let Some(text) = objects.constant_text(row) {
            transfer.place = Place::Text(text);
            text.len() as u32
        } else {
            objects.read(row, &mut self.buffer)?.min(BUFFER) as u32
        };
        transfer.size = Some(size);
        Ok(size)
    }

    /// Up to seven bytes from `offset` on; where they end, and whether that is the end of all.
    pub(super) fn read(
        &self,
        offset: u32,
        to: &mut [u8],
        objects: &mut impl Objects,
    ) -> Result<(usize, bool), Abort> {
        let rest = self.size().saturating_sub(offset) as usize;
        let length = rest.min(to.len());
        let to = to.get_mut(..length).unwrap_or_default();
        let all: &[u8] = match self.transfer.place {
            Place::Buffer => &self.buffer,
            Place::Text(text) => text,
            Place::Domain => &[],
        };
        if self.transfer.place != Place::Domain {
            copy(to, all.get(offset as usize..).unwrap_or_default());
        } else if length != 0 {
            objects.domain_read(self.transfer.address, offset, to)?;
        }
        Ok((length, length == rest))
    }

    /// Bytes of the upload.
    pub(super) fn size(&self) -> u32 {
        self.transfer.size.unwrap_or(0)
    }
}
