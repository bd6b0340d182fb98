//! The independent watchdog. It has its own oscillator, and nothing stops it once it is started.

use crate::chip::pac::IWDG;

/// Timeout in counts of 0.25 ms: 25 ms at the nominal 32 kHz of the oscillator, 17 to 48 ms over
/// its tolerance (data sheet of the STM32F427, table 41).
const RELOAD: u16 = 100;

/// The watchdog.
pub struct Watchdog(IWDG);

impl Watchdog {
    /// Starts it.
    pub fn start(iwdg: IWDG) -> Self {
        const START: u16 = 0xcccc;
        const ACCESS: u16 = 0x5555;
        let key = |key| {
            // SAFETY: the keys are those of RM0090, section 21.4.1.
            iwdg.kr().write(|w| unsafe { w.key().bits(key) });
        };
        key(START);
        key(ACCESS);
        iwdg.pr().write(|w| w.pr().divide_by8());
        iwdg.rlr().write(|w| w.rl().set(RELOAD));
        let mut watchdog = Self(iwdg);
        watchdog.feed();
        watchdog
    }

    /// Restarts the timeout. A new reload value takes effect after up to five cycles of the
    /// oscillator; until then the reset value of 1 s applies.
    pub fn feed(&mut self) {
        const RELOAD_KEY: u16 = 0xaaaa;
        // SAFETY: as above.
        self.0.kr().write(|w| unsafe { w.key().bits(RELOAD_KEY) });
    }
}
