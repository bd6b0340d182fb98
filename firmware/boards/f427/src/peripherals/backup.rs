//! The backup register that survives a restart, and not a loss of the supply (RM0090, section
//! 26.6.20).

use crate::chip::pac::{PWR, RTC};

/// Writes the register. The clock of the power controller is enabled.
pub fn write(mark: u32) {
    // SAFETY: this register has no other user.
    let (power, clock) = unsafe { (&*PWR::ptr(), &*RTC::ptr()) };
    power.cr().modify(|_, w| w.dbp().set_bit());
    // SAFETY: all 32 bits are data.
    clock.bkpr(0).write(|w| unsafe { w.bits(mark) });
}

/// Reads the register.
pub fn read() -> u32 {
    // SAFETY: as above.
    unsafe { &*RTC::ptr() }.bkpr(0).read().bits()
}
