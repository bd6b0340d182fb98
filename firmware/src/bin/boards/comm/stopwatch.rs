//! Microseconds for the stamps of frames, and an interrupt each millisecond.
//!
//! TIM2 counts microseconds; its 32 bits wrap after 71 minutes.

use stm32f4xx_hal::pac::{TIM2, TIM3};

/// The timers run at twice their bus: 80 MHz.
const MEGAHERTZ: u16 = 80;

/// Reads the microseconds.
pub struct Stopwatch;

impl Stopwatch {
    /// Microseconds since the start, modulo 2^32.
    pub fn now_us(&self) -> u32 {
        // SAFETY: a read of one word without effects.
        unsafe { &*TIM2::ptr() }.cnt().read().bits()
    }
}

/// The timer that interrupts each millisecond.
pub struct Millisecond {
    timer: TIM3,
    stopwatch: Stopwatch,
    /// Until the next report.
    left: u16,
}

/// Between two reports in the log, ms.
const INTERVAL_MS: u16 = 10_000;

/// Starts both.
pub fn start(microseconds: TIM2, milliseconds: TIM3) -> (Stopwatch, Millisecond) {
    microseconds.psc().write(|w| w.psc().set(MEGAHERTZ - 1));
    // SAFETY: all 32 bits count.
    microseconds.arr().write(|w| unsafe { w.bits(u32::MAX) });
    microseconds.egr().write(|w| w.ug().set_bit());
    microseconds.cr1().write(|w| w.cen().enabled());

    milliseconds.psc().write(|w| w.psc().set(MEGAHERTZ - 1));
    milliseconds.arr().write(|w| w.arr().set(1000 - 1));
    milliseconds.egr().write(|w| w.ug().set_bit());
    milliseconds.sr().write(|w| w.uif().clear_bit());
    milliseconds.dier().write(|w| w.uie().enabled());
    milliseconds.cr1().write(|w| w.cen().enabled());
    let millisecond = Millisecond {
        timer: milliseconds,
        stopwatch: Stopwatch,
        left: INTERVAL_MS,
    };
    (Stopwatch, millisecond)
}

impl Millisecond {
    /// A millisecond has begun: the interrupt has been heard.
    pub fn begun(&mut self) {
        self.timer.sr().write(|w| w.uif().clear_bit());
    }

    /// Microseconds since the start, modulo 2^32.
    pub fn now_us(&self) -> u32 {
        self.stopwatch.now_us()
    }

    /// Whether the program reports in this millisecond how it fares.
    pub fn is_report_due(&mut self) -> bool {
        self.left = self.left.checked_sub(1).unwrap_or(INTERVAL_MS);
        self.left == 0
    }
}
