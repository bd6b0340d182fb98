//! Microseconds for the time stamps of frames, and an interrupt each millisecond.

use stm32f4xx_hal::pac::{TIM2, TIM3};

/// Timer clock: twice that of APB1.
const CYCLES_PER_US: u16 = 80;

/// Interval between two reports in the log, ms.
const REPORT_INTERVAL_MS: u16 = 10_000;

/// TIM2, which counts microseconds modulo 2^32: it wraps after 71 minutes.
#[derive(Clone, Copy)]
pub struct MicrosecondCounter;

impl MicrosecondCounter {
    /// Microseconds since the start, modulo 2^32.
    pub fn now_us(&self) -> u32 {
        // SAFETY: a read of one word without side effects.
        unsafe { &*TIM2::ptr() }.cnt().read().bits()
    }
}

/// TIM3, which interrupts each millisecond.
pub struct MillisecondTimer {
    timer: TIM3,
    until_report_ms: u16,
}

/// Starts both timers.
pub fn start(microseconds: TIM2, milliseconds: TIM3) -> (MicrosecondCounter, MillisecondTimer) {
    microseconds.psc().write(|w| w.psc().set(CYCLES_PER_US - 1));
    // SAFETY: all 32 bits count.
    microseconds.arr().write(|w| unsafe { w.bits(u32::MAX) });
    microseconds.egr().write(|w| w.ug().set_bit());
    microseconds.cr1().write(|w| w.cen().enabled());

    milliseconds.psc().write(|w| w.psc().set(CYCLES_PER_US - 1));
    milliseconds.arr().write(|w| w.arr().set(1000 - 1));
    milliseconds.egr().write(|w| w.ug().set_bit());
    milliseconds.sr().write(|w| w.uif().clear_bit());
    milliseconds.dier().write(|w| w.uie().enabled());
    milliseconds.cr1().write(|w| w.cen().enabled());
    let millisecond_timer = MillisecondTimer {
        timer: milliseconds,
        until_report_ms: REPORT_INTERVAL_MS,
    };
    (MicrosecondCounter, millisecond_timer)
}

impl MillisecondTimer {
    /// Acknowledges the interrupt. Returns whether a report is due.
    pub fn acknowledge(&mut self) -> bool {
        self.timer.sr().write(|w| w.uif().clear_bit());
        self.until_report_ms = self
            .until_report_ms
            .checked_sub(1)
            .unwrap_or(REPORT_INTERVAL_MS);
        self.until_report_ms == 0
    }
}
