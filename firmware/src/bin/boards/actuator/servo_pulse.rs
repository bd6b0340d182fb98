//! The pulse of an RC receiver, measured by TIM4 at PD12.
//!
//! The timer counts microseconds. The rising edge starts it anew, the falling edge captures its count:
//! the width of the pulse (RM0090, section 18.3.6, PWM input mode). No interrupt is taken.

use stm32f4xx_hal::pac::TIM4;

/// The input.
pub struct ServoPulse {
    tim: TIM4,
}

impl ServoPulse {
    /// Sets the timer up and starts it.
    pub fn new(tim: TIM4) -> Self {
        // 84 MHz / 84.
        tim.psc().write(|w| w.psc().set(84 - 1));
        // Both channels watch input 1. Eight equal samples at 84 MHz make an edge.
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
        Self { tim }
    }

    /// The width of the pulse that ended since this was asked last, us.
    pub fn take_us(&mut self) -> Option<u16> {
        let flags = self.tim.sr().read();
        if !flags.cc2if().bit() {
            return None;
        }
        // Reading the capture clears its flag.
        let width_us = self.tim.ccr2().read().ccr().bits();
        // The count ran over: the line was at one level for 65 ms, and the width is what is left.
        let ran_over = flags.uif().bit();
        self.tim.sr().write(|w| w.uif().clear_bit());
        (!ran_over).then_some(width_us)
    }
}
