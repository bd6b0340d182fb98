//! Checksum of block transfers (CiA 301, 7.2.4.3): polynomial x^16 + x^12 + x^5 + 1, from 0.

/// The checksum `crc` continued over `data`.
pub(super) fn update(crc: u16, data: &[u8]) -> u16 {
    data.iter().fold(crc, |crc, byte| {
        // What eight steps of the polynomial's shift register amount to.
        let top = crc >> 8 ^ u16::from(*byte);
        let top = top ^ top >> 4;
        crc << 8 ^ top << 12 ^ top << 5 ^ top
    })
}

#[cfg(test)]
mod tests {
    #[test]
    fn is_the_checksum_of_the_standard() {
        // The check value that CiA 301 gives for the ASCII digits 1 to 9.
        assert_eq!(super::update(0, b"123456789"), 0x31C3);
        assert_eq!(super::update(super::update(0, b"1234"), b"56789"), 0x31C3);
    }
}
