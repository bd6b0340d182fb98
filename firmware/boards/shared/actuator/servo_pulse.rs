//! Pulse width of an RC receiver, measured by TIM4 at PD12.
//!
//! The timer counts microseconds. A rising edge restarts it, a falling edge captures its count: the
//! width of the pulse (RM0090, section 18.3.6, PWM input mode). It takes no interrupt.

use super::timing::APB1_TIMER_HZ;
use crate::chip::pac::TIM4;

/// The servo pulse input.
pub struct ServoPulse {
    tim: TIM4,
    /// Width of the pulse that ended before this control period, us.
    width_us: Option<u16>,
}

impl ServoPulse {
    /// Sets the timer up and starts it.
    pub fn new(tim: TIM4) -> Self {
        const CYCLES_PER_US: u16 = (APB1_TIMER_HZ / 1_000_000) as u16;
        tim.psc().write(|w| w.psc().set(CYCLES_PER_US - 1));
        // Both channels capture input 1. An edge is eight equal samples at the timer's clock.
        // SAFETY: the codes are those of RM0090, section 18.4.7.
        tim.ccmr1_input().write(|w| unsafe {
            w.cc1s().bits(0b01).ic1f().bits(0b0011);
            w.cc2s().bits(0b10).ic2f().bits(0b0011)
        });
        tim.ccer()
            .write(|w| w.cc2p().set_bit().cc1e().set_bit().cc2e().set_bit());
        // SAFETY: the codes are those of section 18.4.3: trigger TI1FP1, reset mode.
        tim.smcr()
            .write(|w| unsafe { w.ts().bits(0b101).sms().bits(0b100) });
        tim.sr()
            .write(|w| w.uif().clear_bit().cc1if().clear_bit().cc2if().clear_bit());
        // Edges do not set UIF.
        tim.cr1().write(|w| w.urs().counter_only().cen().enabled());
        Self {
            tim,
            width_us: None,
        }
    }

    /// Takes the pulse that ended since the last call, if there is one.
    pub fn finish(&mut self) {
        self.width_us = self.take();
    }

    /// Width of the pulse that was taken last, us.
    pub fn width_us(&self) -> Option<u16> {
        self.width_us
    }

    fn take(&mut self) -> Option<u16> {
        let flags = self.tim.sr().read();
        if !flags.cc2if().bit() {
            return None;
        }
        // Reading the capture clears its flag.
        let width_us = self.tim.ccr2().read().ccr().bits();
        // After an overflow the line was at one level for 65 ms, and the captured width is invalid.
        let has_overflowed = flags.uif().bit();
        self.tim.sr().write(|w| w.uif().clear_bit());
        (!has_overflowed).then_some(width_us)
    }
}
