//! TIM5 counts microseconds once: the return delay of the servo bus, and how long it waits for
//! other servos (RM0090, chapter 18; RM0433, chapter 39).

use crate::{chip::pac::TIM5, peripherals::timing::APB1_TIMER_HZ};

/// The timer, which interrupts when its time has elapsed.
pub struct LineTimer(TIM5);

impl LineTimer {
    /// Sets the timer up, stopped.
    pub fn new(tim: TIM5) -> Self {
        const CYCLES_PER_US: u16 = (APB1_TIMER_HZ / 1_000_000) as u16;
        tim.psc().write(|w| w.psc().set(CYCLES_PER_US - 1));
        // Only the end of a time sets UIF, not the update that loads the prescaler.
        tim.cr1().write(|w| w.urs().counter_only().opm().enabled());
        tim.egr().write(|w| w.ug().update());
        tim.dier().write(|w| w.uie().enabled());
        Self(tim)
    }

    /// Starts a time, us; without one it stops. A time that runs is replaced.
    pub fn start(&mut self, us: Option<u32>) {
        self.0.cr1().modify(|_, w| w.cen().disabled());
        self.0.sr().write(|w| w.uif().clear_bit());
        if let Some(us) = us {
            self.0.cnt().write(|w| w.cnt().set(0));
            self.0.arr().write(|w| w.arr().set(us.max(1)));
            self.0.cr1().modify(|_, w| w.cen().enabled());
        }
    }

    /// Whether a time has elapsed since the last call.
    pub fn take_elapsed(&mut self) -> bool {
        let has_elapsed = self.0.sr().read().uif().bit();
        self.0.sr().write(|w| w.uif().clear_bit());
        has_elapsed
    }
}
