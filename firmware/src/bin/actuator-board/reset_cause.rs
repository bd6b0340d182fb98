//! Why the processor started (RM0090, section 6.3.21).

use stm32f4xx_hal::pac::RCC;

/// The cause, the most telling where several flags stand: a reset of any kind pulls the pin too.
#[derive(Clone, Copy, PartialEq, Eq, defmt::Format)]
pub enum ResetCause {
    /// The supply came up, or fell below the threshold of the brown-out reset.
    Power,
    /// The independent or the window watchdog.
    Watchdog,
    /// The program or a debugger asked for it.
    Software,
    /// Forbidden low-power mode.
    LowPower,
    /// The reset pin.
    Pin,
}

/// Reads the cause and clears it for the next reset.
pub fn take(rcc: &RCC) -> ResetCause {
    let flags = rcc.csr().read();
    rcc.csr().modify(|_, w| w.rmvf().set_bit());
    if flags.wdgrstf().bit() || flags.wwdgrstf().bit() {
        ResetCause::Watchdog
    } else if flags.sftrstf().bit() {
        ResetCause::Software
    } else if flags.lpwrrstf().bit() {
        ResetCause::LowPower
    } else if flags.porrstf().bit() || flags.borrstf().bit() {
        ResetCause::Power
    } else {
        ResetCause::Pin
    }
}
