//! The flash memory as the store uses it.

/// One of the two pages. On the STM32F427 they are sectors 12 and 13 at 0x0810_0000 and
/// 0x0810_4000, 16 KiB each, in bank 2: the program runs from bank 1 while they are erased and
/// written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Page {
    /// The first.
    First,
    /// The second.
    Second,
}

/// Status of the flash.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// Idle; the last operation succeeded.
    Ready,
    /// Erasing or writing.
    Busy,
    /// Idle; the last operation failed.
    Failed,
}

/// Two pages of flash that are erased and written without blocking.
///
/// An erased word reads as [`u32::MAX`]. A word is written at most once after each erase.
pub trait Flash {
    /// Starts to erase a page; called only while not [`Status::Busy`].
    fn start_erase(&mut self, page: Page);

    /// Starts to write the word at `offset` bytes, a multiple of four; called only while not
    /// [`Status::Busy`].
    fn start_program(&mut self, page: Page, offset: u16, word: u32);

    /// Its present status.
    fn status(&mut self) -> Status;

    /// The word at `offset` bytes, a multiple of four; called only while not [`Status::Busy`].
    fn read(&self, page: Page, offset: u16) -> u32;
}
