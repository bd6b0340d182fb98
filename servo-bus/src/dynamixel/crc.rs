//! CRC-16 with the polynomial 8005h, from 0, the high bit first.

/// The CRC of bytes that follow those of another CRC, or 0.
///
/// ```
/// // The ping of the manual.
/// let ping = [0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x03, 0x00, 0x01];
/// assert_eq!(servo_bus::dynamixel::crc(0, &ping), 0x4E19);
/// ```
pub fn crc(before: u16, bytes: &[u8]) -> u16 {
    bytes.iter().fold(before, |crc, byte| {
        (0..8).fold(crc ^ u16::from(*byte) << 8, |crc, _| {
            if crc & 0x8000 == 0 {
                crc << 1
            } else {
                crc << 1 ^ 0x8005
            }
        })
    })
}
