//! CRC of block transfers (CiA 301, 7.2.4.3): polynomial x^16 + x^12 + x^5 + 1, initial value 0.

/// Updates `crc` with `data`.
pub(super) fn update(crc: u16, data: &[u8]) -> u16 {
    data.iter().fold(crc, |crc, byte| {
        // Eight steps of the shift register in closed form.
        let top = crc >> 8 ^ u16::from(*byte);
        let top = top ^ top >> 4;
        crc << 8 ^ top << 12 ^ top << 5 ^ top
    })
}

#[cfg(test)]
mod tests {
    #[test]
    fn crc_matches_the_check_value_of_cia_301() {
        // Check value of CiA 301 for the ASCII string "123456789".
        assert_eq!(super::update(0, b"123456789"), 0x31C3);
        assert_eq!(super::update(super::update(0, b"1234"), b"56789"), 0x31C3);
    }
}
