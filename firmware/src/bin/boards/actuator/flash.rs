//! The two pages of parameters: sectors 12 and 13, the first of bank 2.
//!
//! The program runs from bank 1, which goes on serving while bank 2 is erased (250 ms a sector) or
//! written (16 us a word): RM0090, section 3.5.4, read while write. Nobody waits for it here.

use core::ptr;

use firmware::store::{Flash as Pages, Page, Status};
use stm32f4xx_hal::pac::FLASH;

/// Words are written whole: 32 bits at 2.7 to 3.6 V (table 13).
const WORDS: u8 = 0b10;

/// Flags of the status register (section 3.9.6): EOP; OPERR, WRPERR, PGAERR, PGPERR, PGSERR, RDERR.
const END_OF_OPERATION: u32 = 1;
const ERRORS: u32 = 1 << 1 | 0b1_1111 << 4;

/// The flash interface.
pub struct Flash {
    registers: FLASH,
    /// An operation was started and nobody has heard of its end.
    started: bool,
}

impl Flash {
    /// The interface, at rest and locked.
    pub fn new(registers: FLASH) -> Self {
        Self {
            registers,
            started: false,
        }
    }

    /// Opens the control register and forgets earlier errors.
    ///
    /// The data cache rests from here to the end of the operation: lines that are filled while the
    /// other bank is written may be corrupt (ES0206, section 2.2.12).
    fn unlock(&mut self) {
        self.registers.acr().modify(|_, w| w.dcen().clear_bit());
        if self.registers.cr().read().lock().bit() {
            for key in [0x4567_0123, 0xcdef_89ab] {
                // SAFETY: the keys of section 3.6.1.
                self.registers.keyr().write(|w| unsafe { w.bits(key) });
            }
        }
        // SAFETY: a flag is cleared by a one.
        self.registers
            .sr()
            .write(|w| unsafe { w.bits(END_OF_OPERATION | ERRORS) });
        self.started = true;
    }

    /// What went wrong in the operation that has just ended.
    fn has_failed(&self) -> bool {
        self.registers.sr().read().bits() & ERRORS != 0
    }

    /// The data cache knows nothing of erasing and writing (section 3.5.2): it starts empty.
    fn restart_cache(&self) {
        let access = self.registers.acr();
        access.modify(|_, w| w.dcrst().set_bit());
        access.modify(|_, w| w.dcrst().clear_bit());
        access.modify(|_, w| w.dcen().set_bit());
    }
}

/// Where a word lies.
fn address(page: Page, offset: u16) -> *mut u32 {
    let page = match page {
        Page::First => 0x0810_0000,
        Page::Second => 0x0810_4000,
    };
    // Within the page and aligned, whatever is asked for.
    ptr::with_exposed_provenance_mut(page + usize::from(offset & 0x3ffc))
}

impl Pages for Flash {
    fn start_erase(&mut self, page: Page) {
        self.unlock();
        // Sectors of bank 2 count from 16 (section 3.9.8).
        let sector = match page {
            Page::First => 16,
            Page::Second => 17,
        };
        let control = self.registers.cr();
        // SAFETY: both numbers are those of the section.
        control.write(|w| unsafe {
            w.lock()
                .clear_bit()
                .ser()
                .set_bit()
                .snb()
                .bits(sector)
                .psize()
                .bits(WORDS)
        });
        control.modify(|_, w| w.strt().set_bit());
    }

    fn start_program(&mut self, page: Page, offset: u16, word: u32) {
        self.unlock();
        // SAFETY: as above.
        self.registers
            .cr()
            .write(|w| unsafe { w.lock().clear_bit().pg().set_bit().psize().bits(WORDS) });
        // SAFETY: an aligned word of a sector that holds nothing but parameters.
        unsafe { ptr::write_volatile(address(page, offset), word) };
    }

    fn status(&mut self) -> Status {
        if self.registers.sr().read().bsy().bit() {
            return Status::Busy;
        }
        if self.started {
            self.started = false;
            // Locked, and with neither erasing nor writing selected.
            self.registers.cr().write(|w| w.lock().set_bit());
            self.restart_cache();
        }
        if self.has_failed() {
            Status::Failed
        } else {
            Status::Ready
        }
    }

    fn read(&self, page: Page, offset: u16) -> u32 {
        // SAFETY: an aligned word of memory that is always there.
        unsafe { ptr::read_volatile(address(page, offset)) }
    }
}
