//! What all uploads have in common: where the data come from.

use super::{BUFFER, Objects};
use crate::Abort;
use crate::dictionary::{Address, DataType, Row};
use crate::message::copy;

#[derive(Clone, Copy, Debug)]
enum Source {
    /// The server's buffer, filled when the upload began.
    Buffer,
    /// A constant.
    Text(&'static [u8]),
    Domain,
}

/// An upload under way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Upload {
    address: Address,
    source: Source,
    pub size: u32,
}

impl Upload {
    pub fn begin(
        address: Address,
        buffer: &mut [u8; BUFFER],
        objects: &mut impl Objects,
    ) -> Result<Self, Abort> {
        let row: &Row = objects.entry(address)?;
        if !row.readable() {
            return Err(Abort::WriteOnly);
        }
        let (source, size) = if row.data_type() == DataType::Domain {
            (Source::Domain, objects.domain_size(address)?)
        } else if let Some(text) = objects.constant_text(row) {
            (Source::Text(text), text.len() as u32)
        } else {
            (
                Source::Buffer,
                objects.read(row, buffer)?.min(BUFFER) as u32,
            )
        };
        Ok(Self {
            address,
            source,
            size,
        })
    }

    /// Up to seven bytes from `offset` on; how many there are.
    pub fn read(
        &self,
        offset: u32,
        to: &mut [u8],
        buffer: &[u8; BUFFER],
        objects: &mut impl Objects,
    ) -> Result<usize, Abort> {
        let length = (self.size.saturating_sub(offset) as usize).min(to.len());
        let to = to.get_mut(..length).unwrap_or_default();
        match self.source {
            Source::Buffer => copy(to, buffer.get(offset as usize..).unwrap_or_default()),
            Source::Text(text) => copy(to, text.get(offset as usize..).unwrap_or_default()),
            Source::Domain => {
                if length != 0 {
                    objects.domain_read(self.address, offset, to)?;
                }
                length
            }
        };
        Ok(length)
    }
}
