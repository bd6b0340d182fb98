//! The flash memory as the store uses it.

/// One of the two pages, which can be erased and written while the program runs.
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

/// Most words of a row, of any flash: 256 bits, as in an STM32H743.
pub const MAX_ROW: usize = 8;

/// Two pages of flash that are erased and written without blocking.
///
/// An erased word reads as [`u32::MAX`]. A row is written at most once after each erase.
pub trait Flash {
    /// Words that are written together, at most [`MAX_ROW`]: a flash with an error-correcting code
    /// writes as many as share one.
    const ROW: usize;

    /// Bytes of a page, a multiple of a row and at most 64 KiB.
    const PAGE_BYTES: u32;

    /// Starts to erase a page; called only while not [`Status::Busy`].
    fn start_erase(&mut self, page: Page);

    /// Starts to write the row at `offset` bytes, a multiple of its length; called only while not
    /// [`Status::Busy`].
    fn start_program(&mut self, page: Page, offset: u16, row: &[u32]);

    /// Its present status.
    fn status(&mut self) -> Status;

    /// The word at `offset` bytes, a multiple of four; called only while not [`Status::Busy`].
    fn read(&self, page: Page, offset: u16) -> u32;
}
