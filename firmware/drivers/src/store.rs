//! The flash of the parameters, over `embedded_storage::nor_flash`.
//!
//! `NorFlash` blocks for an erase, which takes 250 ms to seconds, and nothing may block a program
//! that controls a motor. The store therefore uses [`firmware::store::Flash`], which starts
//! operations and polls them. Two adapters connect both traits:
//!
//! * [`NorFlashPages`] is any `NorFlash` as the flash of the store, for chips and programs that may
//!   wait: [`Flash::start_erase`] returns when the page is erased;
//! * [`Waiting`] is the flash of the store as a `NorFlash`, for tools and tests.

use core::cell::RefCell;

use embedded_hal::delay::DelayNs;
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read,
    check_write,
};
use firmware::store::{Flash, MAX_ROW, Page, Status};

/// Bytes of a word.
const WORD: usize = size_of::<u32>();

/// A `NorFlash` as the flash of the store: its first two sectors are the pages.
#[derive(Debug)]
pub struct NorFlashPages<F> {
    flash: RefCell<F>,
    has_failed: bool,
}

impl<F: NorFlash> NorFlashPages<F> {
    /// The pages in this flash.
    pub const fn new(flash: F) -> Self {
        const {
            assert!(F::ERASE_SIZE.is_multiple_of(F::WRITE_SIZE));
            assert!(F::READ_SIZE <= WORD && WORD.is_multiple_of(F::READ_SIZE));
            assert!(F::WRITE_SIZE <= MAX_ROW * WORD);
        }
        Self {
            flash: RefCell::new(flash),
            has_failed: false,
        }
    }

    /// The flash.
    pub fn release(self) -> F {
        self.flash.into_inner()
    }

    const fn start_of(page: Page) -> u32 {
        match page {
            Page::First => 0,
            Page::Second => F::ERASE_SIZE as u32,
        }
    }
}

impl<F: NorFlash> Flash for NorFlashPages<F> {
    const ROW: usize = if F::WRITE_SIZE > WORD {
        F::WRITE_SIZE / WORD
    } else {
        1
    };
    const PAGE_BYTES: u32 = F::ERASE_SIZE as u32;

    /// Blocks until the page is erased.
    fn start_erase(&mut self, page: Page) {
        let start = Self::start_of(page);
        let erased = self
            .flash
            .get_mut()
            .erase(start, start + F::ERASE_SIZE as u32);
        self.has_failed = erased.is_err();
    }

    /// Blocks until the row is written.
    fn start_program(&mut self, page: Page, offset: u16, row: &[u32]) {
        let mut bytes = [[0; WORD]; MAX_ROW];
        for (bytes, word) in bytes.iter_mut().zip(row) {
            *bytes = word.to_le_bytes();
        }
        let address = Self::start_of(page) + u32::from(offset);
        let bytes = bytes.get(..Self::ROW).unwrap_or_default().as_flattened();
        self.has_failed = self.flash.get_mut().write(address, bytes).is_err();
    }

    fn status(&mut self) -> Status {
        match self.has_failed {
            true => Status::Failed,
            false => Status::Ready,
        }
    }

    /// A word that cannot be read is zero, which is neither erased nor any hash of a layout.
    fn read(&self, page: Page, offset: u16) -> u32 {
        let mut bytes = [0; WORD];
        let address = Self::start_of(page) + u32::from(offset);
        // Nothing else borrows it.
        let read = (self.flash.try_borrow_mut()).map(|mut flash| flash.read(address, &mut bytes));
        match read {
            Ok(Ok(())) => u32::from_le_bytes(bytes),
            _ => 0,
        }
    }
}

/// The flash of the store as a `NorFlash`, which waits for each operation: the first page, and
/// behind it the second one.
#[derive(Debug)]
pub struct Waiting<F, D> {
    flash: F,
    delay: D,
}

/// Time between two polls of an operation, us.
const POLL_US: u32 = 20;

/// An operation failed, or its addresses are wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Failed(pub NorFlashErrorKind);

impl NorFlashError for Failed {
    fn kind(&self) -> NorFlashErrorKind {
        self.0
    }
}

impl<F: Flash, D: DelayNs> Waiting<F, D> {
    /// This flash, polled with this delay.
    pub const fn new(flash: F, delay: D) -> Self {
        Self { flash, delay }
    }

    /// The flash.
    pub fn release(self) -> F {
        self.flash
    }

    /// The page of an address, and the offset of the address in it.
    const fn place(address: u32) -> (Page, u16) {
        let page = if address < F::PAGE_BYTES {
            Page::First
        } else {
            Page::Second
        };
        (page, (address % F::PAGE_BYTES) as u16)
    }

    /// Waits for the end of an operation.
    fn wait(&mut self) -> Result<(), Failed> {
        loop {
            match self.flash.status() {
                Status::Busy => self.delay.delay_us(POLL_US),
                Status::Ready => return Ok(()),
                Status::Failed => return Err(Failed(NorFlashErrorKind::Other)),
            }
        }
    }
}

impl<F: Flash, D: DelayNs> ErrorType for Waiting<F, D> {
    type Error = Failed;
}

impl<F: Flash, D: DelayNs> ReadNorFlash for Waiting<F, D> {
    const READ_SIZE: usize = WORD;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Failed> {
        check_read(self, offset, bytes.len()).map_err(Failed)?;
        for (address, bytes) in (offset..).step_by(WORD).zip(bytes.chunks_exact_mut(WORD)) {
            let (page, offset) = Self::place(address);
            bytes.copy_from_slice(&self.flash.read(page, offset).to_le_bytes());
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        2 * F::PAGE_BYTES as usize
    }
}

impl<F: Flash, D: DelayNs> NorFlash for Waiting<F, D> {
    const WRITE_SIZE: usize = F::ROW * WORD;
    const ERASE_SIZE: usize = F::PAGE_BYTES as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Failed> {
        check_erase(self, from, to).map_err(Failed)?;
        for address in (from..to).step_by(Self::ERASE_SIZE) {
            self.flash.start_erase(Self::place(address).0);
            self.wait()?;
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Failed> {
        check_write(self, offset, bytes.len()).map_err(Failed)?;
        let rows = bytes.chunks_exact(Self::WRITE_SIZE);
        for (address, bytes) in (offset..).step_by(Self::WRITE_SIZE).zip(rows) {
            let mut row = [u32::MAX; MAX_ROW];
            for (word, bytes) in row.iter_mut().zip(bytes.as_chunks::<WORD>().0) {
                *word = u32::from_le_bytes(*bytes);
            }
            let (page, offset) = Self::place(address);
            let row = row.get(..F::ROW).unwrap_or_default();
            self.flash.start_program(page, offset, row);
            self.wait()?;
        }
        Ok(())
    }
}
