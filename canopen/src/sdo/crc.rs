//! Checksum of block transfers (CiA 301, 7.2.4.3): polynomial x^16 + x^12 + x^5 + 1, from 0.

/// Remainders of the 16 values of a nibble.
const TABLE: [u16; 16] = table();

const fn table() -> [u16; 16] {
    let mut table = [0; 16];
    let mut nibble = 0;
    while nibble < 16 {
        let mut crc = (nibble as u16) << 12;
        let mut bit = 0;
        while bit < 4 {
            crc = if crc & 0x8000 == 0 {
                crc << 1
            } else {
                crc << 1 ^ 0x1021
            };
            bit += 1;
        }
        table[nibble] = crc;
        nibble += 1;
    }
    table
}

/// The checksum `crc` continued over `data`.
pub(super) fn update(crc: u16, data: &[u8]) -> u16 {
    data.iter()
        .fold(crc, |crc, byte| nibble(nibble(crc, byte >> 4), byte & 15))
}

fn nibble(crc: u16, value: u8) -> u16 {
    let at = (crc >> 12) as u8 ^ value;
    crc << 4 ^ TABLE.get(usize::from(at)).copied().unwrap_or(0)
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
