//! The backup register that survives a restart, and not a loss of the supply (RM0433,
//! chapter 46).

use crate::chip::pac::{PWR, RTC};

/// Writes the register.
pub fn write(mark: u32) {
    // SAFETY: this register has no other user.
    let (power, clock) = unsafe { (&*PWR::ptr(), &*RTC::ptr()) };
    power.cr1().modify(|_, w| w.dbp().set_bit());
    clock.bkpr(0).write(|w| w.bkp().set(mark));
}

/// Reads the register.
pub fn read() -> u32 {
    // SAFETY: as above.
    unsafe { &*RTC::ptr() }.bkpr(0).read().bits()
}
