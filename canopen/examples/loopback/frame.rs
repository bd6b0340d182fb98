//! A CAN frame in memory.

use embedded_can::{ExtendedId, Frame, Id, StandardId};

/// A classical CAN frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CanFrame {
    id: Id,
    remote: bool,
    length: usize,
    data: [u8; 8],
}

impl CanFrame {
    /// With any identifier, of 29 bits if `extended`.
    pub fn raw(
        id: u32,
        extended: bool,
        remote: bool,
        length: usize,
        data: [u8; 8],
    ) -> Option<Self> {
        let id: Id = if extended {
            ExtendedId::new(id)?.into()
        } else {
            StandardId::new(u16::try_from(id).ok()?)?.into()
        };
        (length <= 8).then_some(Self {
            id,
            remote,
            length,
            data,
        })
    }

    /// The identifier, and whether it has 29 bits.
    pub fn raw_id(&self) -> (u32, bool) {
        match self.id {
            Id::Standard(id) => (u32::from(id.as_raw()), false),
            Id::Extended(id) => (id.as_raw(), true),
        }
    }
}

impl Frame for CanFrame {
    fn new(id: impl Into<Id>, data: &[u8]) -> Option<Self> {
        let mut bytes = [0; 8];
        bytes.get_mut(..data.len())?.copy_from_slice(data);
        Some(Self {
            id: id.into(),
            remote: false,
            length: data.len(),
            data: bytes,
        })
    }

    fn new_remote(id: impl Into<Id>, dlc: usize) -> Option<Self> {
        (dlc <= 8).then(|| Self {
            id: id.into(),
            remote: true,
            length: dlc,
            data: [0; 8],
        })
    }

    fn is_extended(&self) -> bool {
        matches!(self.id, Id::Extended(_))
    }

    fn is_remote_frame(&self) -> bool {
        self.remote
    }

    fn id(&self) -> Id {
        self.id
    }

    fn dlc(&self) -> usize {
        self.length
    }

    fn data(&self) -> &[u8] {
        if self.remote {
            &[]
        } else {
            &self.data[..self.length]
        }
    }
}
