//! The flash of bank 2: two pages of parameters in its first two sectors, 12 and 13, and behind
//! them what an update writes (`bootloader::layout`).
//!
//! The program runs from bank 1, which remains readable while bank 2 is erased (250 ms for a
//! sector) or programmed (16 us for a word): RM0090, section 3.5.4, read while write. No function
//! here waits.

use core::{ptr, slice, task::Poll};

use bootloader::{FlashError, PolledFlash, ReadFlash};
use firmware::store::{Flash as Pages, Page, Status};

use crate::chip::pac::FLASH;

/// Parallelism of 32 bits, at 2.7 to 3.6 V (table 13).
const PARALLELISM_32: u8 = 0b10;

/// Flags of the status register (section 3.9.6): EOP; OPERR, WRPERR, PGAERR, PGPERR, PGSERR, RDERR.
const END_OF_OPERATION: u32 = 1;
const ERRORS: u32 = 1 << 1 | 0b1_1111 << 4;

/// The flash interface.
pub struct Flash {
    registers: FLASH,
    /// An operation was started, and its end is not handled yet.
    is_started: bool,
}

impl Flash {
    /// The interface, idle and locked.
    pub fn new(registers: FLASH) -> Self {
        Self {
            registers,
            is_started: false,
        }
    }

    /// The option bytes (section 3.9.10): read protection, write protection, brown-out level,
    /// hardware watchdog.
    pub fn option_bytes(&self) -> u32 {
        self.registers.optcr().read().bits()
    }

    /// Brown-out reset level: 3 is 2.7 V, 0 is off (section 3.9.10).
    pub fn brown_out_level(&self) -> u8 {
        0b11 - self.registers.optcr().read().bor_lev().bits()
    }

    /// Warns of option bytes that are not as `docs/hardware.md` requires.
    pub fn check_option_bytes(&self) {
        const BOOTLOADER_SECTORS: u32 = 0b11 << 16;
        if self.brown_out_level() != 3 {
            defmt::warn!("the brown-out reset level is not 3");
        }
        if self.option_bytes() & BOOTLOADER_SECTORS != 0 {
            defmt::warn!("the sectors of the bootloader are not write-protected");
        }
    }

    /// Unlocks the control register and clears earlier errors.
    ///
    /// The data cache is off until the end of the operation: lines that are filled while the other
    /// bank is written may be corrupt (ES0206, section 2.2.12).
    fn unlock(&mut self) {
        self.registers.acr().modify(|_, w| w.dcen().clear_bit());
        if self.registers.cr().read().lock().bit() {
            for key in [0x4567_0123, 0xcdef_89ab] {
                // SAFETY: the keys of section 3.6.1.
                self.registers.keyr().write(|w| unsafe { w.bits(key) });
            }
        }
        // SAFETY: ones clear flags.
        self.registers
            .sr()
            .write(|w| unsafe { w.bits(END_OF_OPERATION | ERRORS) });
        self.is_started = true;
    }

    /// Whether an operation was started whose end is not handled yet.
    pub fn is_started(&self) -> bool {
        self.is_started
    }

    /// Selects the erase of a sector and starts it.
    fn erase(&mut self, sector: u8) {
        self.unlock();
        // Sectors of bank 2, from 12 on, are numbered from 16 (section 3.9.8).
        let number = sector.wrapping_add(4);
        let control = self.registers.cr();
        // SAFETY: the codes are those of that section.
        control.write(|w| unsafe {
            w.lock()
                .clear_bit()
                .ser()
                .set_bit()
                .snb()
                .bits(number)
                .psize()
                .bits(PARALLELISM_32)
        });
        control.modify(|_, w| w.strt().set_bit());
    }

    /// Selects programming, and writes a word.
    fn program(&mut self, address: *mut u32, word: u32) {
        self.unlock();
        // SAFETY: as above.
        self.registers.cr().write(|w| unsafe {
            w.lock()
                .clear_bit()
                .pg()
                .set_bit()
                .psize()
                .bits(PARALLELISM_32)
        });
        // SAFETY: the callers pass aligned addresses of sectors of bank 2, which hold no code.
        unsafe { ptr::write_volatile(address, word) };
    }

    /// Ends the last operation if it is not busy any more; returns whether it is.
    fn is_busy(&mut self) -> bool {
        if self.registers.sr().read().bsy().bit() {
            return true;
        }
        if self.is_started {
            self.is_started = false;
            // Locked, with neither erase nor programming selected.
            self.registers.cr().write(|w| w.lock().set_bit());
            self.restart_cache();
        }
        false
    }

    /// Whether the last operation failed.
    fn has_failed(&self) -> bool {
        self.registers.sr().read().bits() & ERRORS != 0
    }

    /// Erasing and programming do not update the data cache (section 3.5.2): it restarts empty.
    fn restart_cache(&self) {
        let access = self.registers.acr();
        access.modify(|_, w| w.dcrst().set_bit());
        access.modify(|_, w| w.dcrst().clear_bit());
        access.modify(|_, w| w.dcen().set_bit());
    }
}

/// Address of a word of a page.
fn address(page: Page, offset: u16) -> *mut u32 {
    let page = match page {
        Page::First => 0x0810_0000,
        Page::Second => 0x0810_4000,
    };
    // The mask keeps the address within the page and aligned.
    ptr::with_exposed_provenance_mut(page + usize::from(offset & 0x3ffc))
}

impl Pages for Flash {
    const ROW: usize = 1;
    const PAGE_BYTES: u32 = 16 << 10;

    fn start_erase(&mut self, page: Page) {
        self.erase(match page {
            Page::First => 12,
            Page::Second => 13,
        });
    }

    fn start_program(&mut self, page: Page, offset: u16, row: &[u32]) {
        let Some(word) = row.first() else { return };
        self.program(address(page, offset), *word);
    }

    fn status(&mut self) -> Status {
        if self.is_busy() {
            Status::Busy
        } else if self.has_failed() {
            Status::Failed
        } else {
            Status::Ready
        }
    }

    fn read(&self, page: Page, offset: u16) -> u32 {
        // SAFETY: the address is aligned and always readable.
        unsafe { ptr::read_volatile(address(page, offset)) }
    }
}

impl ReadFlash for Flash {
    fn bytes(&self, address: u32, length: u32) -> &[u8] {
        let start = ptr::with_exposed_provenance(address as usize);
        // SAFETY: the callers stay within the layout of the bootloader, which is flash throughout.
        // It changes only through functions that borrow this value exclusively.
        unsafe { slice::from_raw_parts(start, length as usize) }
    }

    fn word(&self, address: u32) -> u32 {
        // SAFETY: as above, and the address is aligned.
        unsafe { ptr::read_volatile(ptr::with_exposed_provenance(address as usize)) }
    }
}

impl PolledFlash for Flash {
    fn start_erase(&mut self, sector: u8) {
        self.erase(sector);
    }

    fn start_program(&mut self, address: u32, word: u32) {
        self.program(ptr::with_exposed_provenance_mut(address as usize), word);
    }

    /// The errors of an operation whose end is already handled are those of a save.
    fn ended(&mut self) -> Poll<Result<(), FlashError>> {
        let was_started = self.is_started;
        if self.is_busy() {
            Poll::Pending
        } else if was_started && self.has_failed() {
            Poll::Ready(Err(FlashError))
        } else {
            Poll::Ready(Ok(()))
        }
    }
}
