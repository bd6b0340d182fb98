//! What all downloads have in common: collecting the data and handing them over.

use core::task::Poll;

use super::{BUFFER, Data, Objects, State, Step};
use crate::Abort;
use crate::dictionary::{Address, DataType, Row};
use crate::message::copy;

/// A download under way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Download {
    row: &'static Row,
    announced: Option<u32>,
    received: u32,
}

impl Download {
    pub fn begin(
        address: Address,
        announced: Option<u32>,
        objects: &mut impl Objects,
    ) -> Result<Self, Abort> {
        let row = objects.entry(address)?;
        objects.check_write(row, announced)?;
        if row.data_type() == DataType::Domain {
            objects.domain_begin(address, announced)?;
        }
        Ok(Self {
            row,
            announced,
            received: 0,
        })
    }

    fn domain(&self) -> bool {
        self.row.data_type() == DataType::Domain
    }

    /// Takes the next bytes.
    pub fn take(
        &mut self,
        data: &[u8],
        buffer: &mut [u8; BUFFER],
        objects: &mut impl Objects,
    ) -> Result<(), Abort> {
        let offset = self.received;
        let received = offset
            .checked_add(data.len() as u32)
            .ok_or(Abort::TooLong)?;
        if self.announced.is_some_and(|size| received > size) {
            return Err(Abort::TooLong);
        }
        if self.domain() {
            objects.domain_write(self.row.address(), offset, data)?;
        } else {
            let room = buffer.get_mut(offset as usize..).unwrap_or_default();
            if copy(room, data) < data.len() {
                return Err(Abort::TooLong);
            }
        }
        self.received = received;
        Ok(())
    }

    /// All data are there. `reply` is what the client hears when the application has them.
    pub fn finish(self, reply: Data, buffer: &[u8; BUFFER], objects: &mut impl Objects) -> Step {
        if self.announced.is_some_and(|size| self.received < size) {
            return Err(Abort::TooShort);
        }
        let done = if self.domain() {
            objects.domain_end(self.row.address(), self.received)
        } else {
            let data = buffer.get(..self.received as usize).ok_or(Abort::TooLong)?;
            objects.check_write(self.row, Some(self.received))?;
            objects.write(self.row, data)
        };
        match done {
            Poll::Ready(Ok(())) => Ok((State::Idle, Some(reply))),
            Poll::Ready(Err(code)) => Err(code),
            Poll::Pending => Ok((State::Finishing(self, reply), None)),
        }
    }

    pub fn cancel(self, objects: &mut impl Objects) {
        let address = self.row.address();
        if self.domain() || matches!(address.index, 0x1010 | 0x1011) {
            objects.domain_cancel(address);
        }
    }
}
