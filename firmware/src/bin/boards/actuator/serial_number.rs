//! What tells this chip from others.

use crc::{CRC_32_ISO_HDLC, Crc, NoTable};
use stm32f4xx_hal::signature::Uid;

/// A hash of the unique ID of 96 bits (RM0090, section 39.1): two chips have the same once in 4 thousand million times.
pub fn serial_number() -> u32 {
    let id: &[u8; 12] = {
        // SAFETY: twelve bytes of read-only memory that is always there.
        unsafe { &*core::ptr::from_ref(Uid::get()).cast() }
    };
    Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC).checksum(id)
}
