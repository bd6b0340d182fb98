//! The flash as the bootloader uses it, and as the program does while it drives.

use core::task::Poll;

/// A flash operation failed: the flash controller reported an error, or the content that was read
/// back is not the content that was written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FlashError;

/// A flash whose content is in the address space.
///
/// An erased word reads as [`u32::MAX`].
pub trait ReadFlash {
    /// `length` bytes from `address` on. Both are within the flash.
    fn bytes(&self, address: u32, length: u32) -> &[u8];

    /// The word at an address, a multiple of four.
    fn word(&self, address: u32) -> u32 {
        let word = self.bytes(address, 4).first_chunk().copied();
        word.map_or(u32::MAX, u32::from_le_bytes)
    }
}

/// A flash that is erased by sectors and programmed by words of 32 bits, which clears bits. All
/// functions wait for the end of the operation.
pub trait Flash: ReadFlash {
    /// Erases the sector of this number.
    ///
    /// # Errors
    /// The flash controller reported an error.
    fn erase(&mut self, sector: u8) -> Result<(), FlashError>;

    /// Programs the word at an address, a multiple of four.
    ///
    /// # Errors
    /// The flash controller reported an error.
    fn program(&mut self, address: u32, word: u32) -> Result<(), FlashError>;
}

/// As [`Flash`], with functions that do not wait: the program of the board continues meanwhile. It
/// is read, and the next operation is started, only when the last one has ended.
pub trait PolledFlash: ReadFlash {
    /// Starts to erase the sector of this number.
    fn start_erase(&mut self, sector: u8);

    /// Starts to program the word at an address, a multiple of four.
    fn start_program(&mut self, address: u32, word: u32);

    /// How the last operation has ended, if it has.
    fn ended(&mut self) -> Poll<Result<(), FlashError>>;
}
