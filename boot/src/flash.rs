//! The flash as the bootloader uses it.

/// A flash operation failed: the hardware has told an error, or the content that was read back is
/// not the content that was written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FlashError;

/// A flash that is erased by sectors and programmed by words of 32 bits. All functions wait for the
/// end of the operation.
///
/// An erased word reads as [`u32::MAX`]; programming clears bits.
pub trait Flash {
    /// `length` bytes from `address` on. Both are within the flash.
    fn bytes(&self, address: u32, length: u32) -> &[u8];

    /// The word at an address, a multiple of four.
    fn word(&self, address: u32) -> u32 {
        let word = self.bytes(address, 4).first_chunk().copied();
        word.map_or(u32::MAX, u32::from_le_bytes)
    }

    /// Erases the sector of this number.
    ///
    /// # Errors
    /// The hardware has told an error.
    fn erase(&mut self, sector: u8) -> Result<(), FlashError>;

    /// Programs the word at an address, a multiple of four.
    ///
    /// # Errors
    /// The hardware has told an error.
    fn program(&mut self, address: u32, word: u32) -> Result<(), FlashError>;
}
