//! Identifiers out of the controller's registers.

use embedded_can::{ExtendedId, Id, StandardId};

/// An identifier out of the fields of a register.
pub fn identifier(extended: bool, base: u16, extension: u32) -> Id {
    if extended {
        let raw = u32::from(base & 0x7ff) << 18 | extension & 0x3_ffff;
        Id::Extended(ExtendedId::new(raw).unwrap_or(ExtendedId::ZERO))
    } else {
        Id::Standard(StandardId::new(base & 0x7ff).unwrap_or(StandardId::ZERO))
    }
}
