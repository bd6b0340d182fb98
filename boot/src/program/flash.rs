//! The flash, with functions that wait.
//!
//! The core stalls while bank 1 is erased or programmed (RM0090, section 3.5.4), and runs on while
//! bank 2 is.

use core::{ptr, slice};

use bootloader::{Flash, FlashError, ReadFlash};
use stm32f4xx_hal::pac::FLASH;

/// Parallelism of 32 bits, at 2.7 to 3.6 V (RM0090, table 13).
const PARALLELISM_32: u8 = 0b10;

/// Flags of the status register (section 3.9.6): EOP; OPERR, WRPERR, PGAERR, PGPERR, PGSERR, RDERR.
const END_OF_OPERATION: u32 = 1;
const ERRORS: u32 = 1 << 1 | 0b1_1111 << 4;

/// The flash.
pub struct BlockingFlash(FLASH);

impl BlockingFlash {
    /// The flash, locked. Its data cache is off, as after a reset (ES0206, section 2.2.12).
    pub fn new(registers: FLASH) -> Self {
        Self(registers)
    }

    fn unlock(&self) {
        if self.0.cr().read().lock().bit() {
            for key in [0x4567_0123, 0xcdef_89ab] {
                // SAFETY: the keys of section 3.6.1.
                self.0.keyr().write(|w| unsafe { w.bits(key) });
            }
        }
        // SAFETY: ones clear flags.
        self.0
            .sr()
            .write(|w| unsafe { w.bits(END_OF_OPERATION | ERRORS) });
    }

    /// Waits for the end of the operation, then locks the flash.
    fn finish(&self) -> Result<(), FlashError> {
        while self.0.sr().read().bsy().bit() {}
        self.0.cr().write(|w| w.lock().set_bit());
        if self.0.sr().read().bits() & ERRORS == 0 {
            Ok(())
        } else {
            Err(FlashError)
        }
    }
}

impl ReadFlash for BlockingFlash {
    fn bytes(&self, address: u32, length: u32) -> &[u8] {
        let start = ptr::with_exposed_provenance(address as usize);
        // SAFETY: the callers stay within the layout, which is flash throughout. It changes only
        // through functions that borrow this value exclusively.
        unsafe { slice::from_raw_parts(start, length as usize) }
    }

    fn word(&self, address: u32) -> u32 {
        // SAFETY: as above, and the address is aligned.
        unsafe { ptr::read_volatile(ptr::with_exposed_provenance(address as usize)) }
    }
}

impl Flash for BlockingFlash {
    fn erase(&mut self, sector: u8) -> Result<(), FlashError> {
        self.unlock();
        // Sectors of bank 2, from 12 on, are numbered from 16 in the register (section 3.9.8).
        let number = if sector < 12 { sector } else { sector + 4 };
        // SAFETY: the codes are those of that section.
        self.0.cr().write(|w| unsafe {
            w.lock()
                .clear_bit()
                .ser()
                .set_bit()
                .snb()
                .bits(number)
                .psize()
                .bits(PARALLELISM_32)
        });
        self.0.cr().modify(|_, w| w.strt().set_bit());
        self.finish()
    }

    fn program(&mut self, address: u32, word: u32) -> Result<(), FlashError> {
        self.unlock();
        // SAFETY: as above.
        self.0.cr().write(|w| unsafe {
            w.lock()
                .clear_bit()
                .pg()
                .set_bit()
                .psize()
                .bits(PARALLELISM_32)
        });
        // SAFETY: the callers program the regions of the layout only.
        unsafe {
            ptr::write_volatile(ptr::with_exposed_provenance_mut(address as usize), word);
        }
        self.finish()
    }
}
