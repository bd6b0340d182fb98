//! The two flash pages of parameters: the first two sectors of bank 2.
//!
//! The program runs from bank 1, which remains readable while bank 2 is erased (1 s for a sector)
//! or programmed (100 us for a row): RM0433, section 4.3.11. No function here waits.
//!
//! A row of 256 bits shares an error-correcting code. A loss of power in a write or an erase can
//! leave a row whose code is wrong by more than it corrects; a read of it is a bus error (section
//! 4.3.12), which is masked here: its words read as zeros, and the page as corrupt.

use core::{arch::asm, ptr};

use cortex_m::peripheral::SCB;
use firmware::store::{Flash as Pages, Page, Status};

use crate::chip::pac::FLASH;

/// Addresses of the pages.
const FIRST: usize = 0x0810_0000;
const SECOND: usize = 0x0812_0000;

/// Writes 64 bits at once, at 2.7 to 3.6 V (section 4.3.9).
const PARALLELISM_64: u8 = 0b11;

/// Flags of errors in the status register (section 4.9.26): WRPERR, PGSERR, STRBERR, INCERR,
/// OPERR; and of two errors in a row.
const ERRORS: u32 = 0b1_0111 << 17 | 1 << 22;
const DOUBLE_ERROR: u32 = 1 << 26;

/// EOP and all errors.
const ALL_FLAGS: u32 = 1 << 16 | ERRORS | 0b1111 << 23;

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

    /// The option bytes (section 4.9.8): read protection, brown-out level, hardware watchdog.
    pub fn option_bytes(&self) -> u32 {
        self.registers.optsr_cur().read().bits()
    }

    /// Warns of a brown-out reset level that is not 3, 2.7 V (section 4.9.8).
    pub fn check_option_bytes(&self) {
        if self.registers.optsr_cur().read().bor_lev().bits() != 3 {
            defmt::warn!("the brown-out reset level is not 3");
        }
    }

    /// Whether an operation was started whose end is not handled yet.
    pub fn is_started(&self) -> bool {
        self.is_started
    }

    /// Unlocks the control register of bank 2 and clears earlier errors.
    fn unlock(&mut self) {
        let bank = self.registers.bank2();
        if bank.cr().read().lock().bit() {
            for key in [0x4567_0123, 0xcdef_89ab] {
                // SAFETY: the keys of section 4.5.1.
                bank.keyr().write(|w| unsafe { w.bits(key) });
            }
        }
        // SAFETY: ones clear flags.
        bank.ccr().write(|w| unsafe { w.bits(ALL_FLAGS) });
        self.is_started = true;
    }
}

/// Address of a word of a page.
fn address(page: Page, offset: u16) -> *mut u32 {
    let page = match page {
        Page::First => FIRST,
        Page::Second => SECOND,
    };
    ptr::with_exposed_provenance_mut(page + usize::from(offset & 0xfffc))
}

/// Reads a word with bus errors masked, which take all interrupts with them for the time of one
/// read (PM0253, CCR.BFHFNMIGN).
fn read_masked(address: *const u32) -> u32 {
    const BFHFNMIGN: u32 = 1 << 8;
    // SAFETY: no other code changes this register, and the address is aligned and readable; with
    // FAULTMASK set and BFHFNMIGN, an error of the bus has no effect.
    unsafe {
        let control = &(*SCB::PTR).ccr;
        asm!(
            "cpsid f",
            "dsb",
            "isb",
            options(nomem, nostack, preserves_flags)
        );
        control.modify(|bits| bits | BFHFNMIGN);
        let word = ptr::read_volatile(address);
        asm!("dsb", options(nostack, preserves_flags));
        control.modify(|bits| bits & !BFHFNMIGN);
        asm!("cpsie f", "isb", options(nomem, nostack, preserves_flags));
        word
    }
}

impl Pages for Flash {
    const ROW: usize = 8;
    // The sectors have twice as many.
    const PAGE_BYTES: u32 = 64 << 10;

    fn start_erase(&mut self, page: Page) {
        self.unlock();
        let sector = match page {
            Page::First => 0,
            Page::Second => 1,
        };
        let control = self.registers.bank2().cr();
        // SAFETY: a sector and a parallelism that exist.
        control.write(|w| unsafe {
            w.lock().clear_bit().ser().set_bit().snb().bits(sector);
            w.psize().bits(PARALLELISM_64)
        });
        control.modify(|_, w| w.start().set_bit());
    }

    fn start_program(&mut self, page: Page, offset: u16, row: &[u32]) {
        self.unlock();
        // SAFETY: as above.
        self.registers.bank2().cr().write(|w| unsafe {
            w.lock().clear_bit().pg().set_bit();
            w.psize().bits(PARALLELISM_64)
        });
        for (offset, word) in (offset..).step_by(4).zip(row) {
            // SAFETY: the address is aligned, in a sector that holds parameters only.
            unsafe { ptr::write_volatile(address(page, offset), *word) };
        }
    }

    fn status(&mut self) -> Status {
        let bank = self.registers.bank2();
        let status = bank.sr().read();
        if status.bsy().bit() || status.qw().bit() {
            return Status::Busy;
        }
        if self.is_started {
            self.is_started = false;
            // Neither erase nor programming selected, then locked.
            // SAFETY: a parallelism that exists.
            bank.cr()
                .write(|w| unsafe { w.lock().clear_bit().psize().bits(PARALLELISM_64) });
            bank.cr().modify(|_, w| w.lock().set_bit());
        }
        if status.bits() & ERRORS != 0 {
            Status::Failed
        } else {
            Status::Ready
        }
    }

    fn read(&self, page: Page, offset: u16) -> u32 {
        let word = read_masked(address(page, offset));
        let bank = self.registers.bank2();
        if bank.sr().read().bits() & DOUBLE_ERROR == 0 {
            return word;
        }
        // SAFETY: a one clears the flag.
        bank.ccr().write(|w| unsafe { w.bits(DOUBLE_ERROR) });
        0
    }
}
