//! CAN frame in the internal form of the services.

use embedded_can::{ExtendedId, Frame, Id, StandardId};

/// Bit 29 of a COB-ID: the identifier has 29 bits (CiA 301, 7.5.2).
pub(crate) const EXTENDED: u32 = 1 << 29;
/// CAN-ID of a COB-ID including bit 29, which together identify a frame on the bus.
pub(crate) const IDENTIFIER: u32 = 0x3FFF_FFFF;

/// A frame with its identifier in the layout of a COB-ID: bit 29 distinguishes 29-bit from 11-bit
/// identifiers, so that one comparison covers both.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Message {
    pub id: u32,
    pub remote: bool,
    pub length: u8,
    pub data: [u8; 8],
}

impl Message {
    /// A data frame with the first eight bytes of `data`.
    pub fn new(id: u32, data: &[u8]) -> Self {
        let mut message = Self {
            id,
            remote: false,
            length: 0,
            data: [0; 8],
        };
        message.length = copy(&mut message.data, data) as u8;
        message
    }

    /// `None` for frames longer than classical CAN allows.
    pub fn from_frame(frame: &impl Frame) -> Option<Self> {
        if frame.dlc() > 8 {
            return None;
        }
        let id = match frame.id() {
            Id::Standard(id) => u32::from(id.as_raw()),
            Id::Extended(id) => id.as_raw() | EXTENDED,
        };
        let mut message = Self {
            id,
            remote: frame.is_remote_frame(),
            length: frame.dlc() as u8,
            data: [0; 8],
        };
        if !message.remote {
            copy(&mut message.data, frame.data());
        }
        Some(message)
    }

    /// `None` if the driver's frame type rejects it.
    pub fn to_frame<F: Frame>(self) -> Option<F> {
        F::new(bus_id(self.id)?, self.payload())
    }

    pub fn payload(&self) -> &[u8] {
        self.data
            .get(..usize::from(self.length))
            .unwrap_or(&self.data)
    }
}

/// The CAN identifier of a COB-ID.
pub(crate) fn bus_id(cob_id: u32) -> Option<Id> {
    if cob_id & EXTENDED == 0 {
        Some(StandardId::new(u16::try_from(cob_id).ok()?)?.into())
    } else {
        Some(ExtendedId::new(cob_id & !EXTENDED)?.into())
    }
}

/// Copies as many bytes as fit; returns their number.
pub(crate) fn copy(to: &mut [u8], from: &[u8]) -> usize {
    let length = to.len().min(from.len());
    for (to, from) in to.iter_mut().zip(from) {
        *to = *from;
    }
    length
}

/// Restricted 11-bit CAN-IDs, which must not be assigned to a service (CiA 301, 7.3.5).
pub(crate) fn restricted(id: u32) -> bool {
    matches!(
        id,
        0x000..=0x07F
            | 0x101..=0x180
            | 0x581..=0x5FF
            | 0x601..=0x67F
            | 0x6E0..=0x6FF
            | 0x701..=0x7FF
    )
}

/// Whether the identifier of a COB-ID may be assigned to a service: bits 11 to 28 must be 0 for an
/// 11-bit identifier.
pub(crate) fn assignable(cob_id: u32) -> bool {
    let id = cob_id & IDENTIFIER;
    if id & EXTENDED != 0 {
        true
    } else {
        id <= 0x7FF && !restricted(id)
    }
}

/// Whether COB-ID `old` of a service may change to `new`. The identifier must not change while the
/// service is `in_use`.
pub(crate) fn cob_id_change_allowed(new: u32, old: u32, in_use: bool) -> bool {
    assignable(new) && !(in_use && (new ^ old) & IDENTIFIER != 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn restricted_identifiers_match_the_table_of_cia_301() {
        for id in [
            0, 1, 0x7F, 0x101, 0x180, 0x581, 0x601, 0x67F, 0x6E0, 0x701, 0x780, 0x7FF,
        ] {
            assert!(restricted(id), "{id:#X}");
        }
        for id in [0x80, 0x81, 0x100, 0x181, 0x580, 0x600, 0x680, 0x6DF, 0x700] {
            assert!(!restricted(id), "{id:#X}");
        }
    }

    #[test]
    fn bits_above_an_11_bit_identifier_are_refused() {
        assert!(assignable(0x181));
        assert!(!assignable(0x1181));
        assert!(assignable(EXTENDED | 0x1181));
    }
}
