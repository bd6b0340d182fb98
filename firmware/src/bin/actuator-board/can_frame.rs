//! A frame on its way between the bus and the application.

use embedded_can::{ExtendedId, Id, StandardId};

/// A frame of the classical format.
#[derive(Clone, Copy)]
pub struct CanFrame {
    id: Id,
    remote: bool,
    /// 0 to 8.
    dlc: u8,
    data: [u8; 8],
}

impl CanFrame {
    /// A frame from the bus. Length codes from 9 to 15 are allowed there and mean 8 bytes (ISO 11898-1).
    pub fn received(id: Id, remote: bool, length_code: u8, data: [u8; 8]) -> Self {
        let dlc = if length_code < 8 { length_code } else { 8 };
        Self {
            id,
            remote,
            dlc,
            data,
        }
    }

    /// All eight bytes; those behind the length mean nothing.
    pub fn bytes(&self) -> [u8; 8] {
        self.data
    }
}

impl embedded_can::Frame for CanFrame {
    fn new(id: impl Into<Id>, data: &[u8]) -> Option<Self> {
        let mut bytes = [0; 8];
        bytes
            .get_mut(..data.len())?
            .iter_mut()
            .zip(data)
            .for_each(|(to, from)| *to = *from);
        Some(Self {
            id: id.into(),
            remote: false,
            dlc: data.len() as u8,
            data: bytes,
        })
    }

    fn new_remote(id: impl Into<Id>, dlc: usize) -> Option<Self> {
        (dlc <= 8).then(|| Self {
            id: id.into(),
            remote: true,
            dlc: dlc as u8,
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
        usize::from(self.dlc)
    }

    fn data(&self) -> &[u8] {
        let length = if self.remote { 0 } else { self.dlc() };
        self.data.get(..length).unwrap_or(&[])
    }
}

/// An identifier out of the fields of a register.
pub fn identifier(extended: bool, base: u16, extension: u32) -> Id {
    if extended {
        let raw = u32::from(base & 0x7ff) << 18 | extension & 0x3_ffff;
        Id::Extended(ExtendedId::new(raw).unwrap_or(ExtendedId::ZERO))
    } else {
        Id::Standard(StandardId::new(base & 0x7ff).unwrap_or(StandardId::ZERO))
    }
}
