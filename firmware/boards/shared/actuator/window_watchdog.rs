//! The window watchdog: it resets the processor if it is fed too late, and also if it is fed too
//! early, as by a program that runs in a loop.

use model_core::time::CONTROL_RATE_HZ;

use crate::chip::pac::{WWDG, wwdg::cfr::WDGTB};

/// Prescaler, and the counter's value when it is fed. The counter counts its bus' 42 MHz divided by
/// 4096 and the prescaler, and resets when it falls below 40h (RM0090, section 22.3; RM0433,
/// chapter 44):
///
/// | control step | a count | reset after it was fed |
/// |---|---|---|
/// | 250 Hz | 0.78 ms | 31 + 1 counts, 24.2 to 25.0 ms |
/// | 1 kHz | 0.20 ms | 63 + 1 counts, 12.3 to 12.5 ms |
const FIGURES: (WDGTB, u8) = match CONTROL_RATE_HZ {
    250 => (WDGTB::Div8, 0x5f),
    1_000 => (WDGTB::Div2, 0x7f),
    _ => panic!("no figures for this rate"),
};

/// Feeding is permitted from this count on: 2 to 3 counts, at most 2.4 or 0.6 ms, after the last
/// time. It is fed after steps that end in the first update period of their control period: at
/// least 3 or 0.75 ms apart.
const WINDOW: u8 = FIGURES.1 - 2;

/// The window watchdog. Nothing stops it once it was fed.
pub struct WindowWatchdog(WWDG);

impl WindowWatchdog {
    /// Sets it up; the first feeding starts it. Its clock is enabled.
    pub fn new(watchdog: WWDG) -> Self {
        watchdog.cfr().write(|w| {
            w.wdgtb().variant(FIGURES.0);
            w.w().set(WINDOW)
        });
        Self(watchdog)
    }

    /// Restarts the timeout.
    pub fn feed(&mut self) {
        self.0.cr().write(|w| w.wdga().set_bit().t().set(FIGURES.1));
    }
}
