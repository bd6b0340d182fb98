//! The window watchdog: it resets the processor if it is fed too late, and also if it is fed too
//! early, as by a program that runs in a loop.

use crate::chip::pac::WWDG;

/// The counter counts its bus' 42 MHz divided by 4096 x 8, 0.78 ms each, and resets when it falls
/// below 40h (RM0090, section 22.3; RM0433, chapter 44): 31 + 1 counts, 24.2 to 25.0 ms after it
/// was fed.
const FED: u8 = 0x5f;

/// Feeding is permitted from this count on: 2 to 3 counts, at most 2.4 ms, after the last time. It
/// is fed after steps that end in the first PWM period of their control period: at least 3 ms
/// apart.
const WINDOW: u8 = FED - 2;

/// The window watchdog. Nothing stops it once it was fed.
pub struct WindowWatchdog(WWDG);

impl WindowWatchdog {
    /// Sets it up; the first feeding starts it. Its clock is enabled.
    pub fn new(watchdog: WWDG) -> Self {
        watchdog.cfr().write(|w| {
            w.wdgtb().div8();
            w.w().set(WINDOW)
        });
        Self(watchdog)
    }

    /// Restarts the timeout.
    pub fn feed(&mut self) {
        self.0.cr().write(|w| w.wdga().set_bit().t().set(FED));
    }
}
