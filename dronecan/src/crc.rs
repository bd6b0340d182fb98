//! The CRC with which a transfer of several frames begins.

use ::crc::{CRC_16_IBM_3740, Crc, NoTable};

/// CRC-16-CCITT-FALSE.
const CRC: Crc<u16, NoTable> = Crc::<u16, NoTable>::new(&CRC_16_IBM_3740);

/// The CRC of a payload of this data type: the signature comes before it.
#[must_use]
pub fn crc(signature: u64, payload: &[u8]) -> u16 {
    let mut digest = CRC.digest();
    digest.update(&signature.to_le_bytes());
    digest.update(payload);
    digest.finalize()
}
