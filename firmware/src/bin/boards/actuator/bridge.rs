//! TIM1 and the H-bridge: two complementary legs, PWM, dead time, hardware over-current trip.
//!
//! The leg of the voltage's sign switches, the low side of the other one is on: the motor is driven
//! for the share of the period that the compare value gives, and braked for the rest.
//!
//! The outputs are off, with all four switches open, while `MOE` is clear (RM0090, table 95, with
//! `OSSI` set: driven to their idle levels, which are low). `MOE` is cleared by any reset, in
//! hardware by a low level at `BKIN`, and while a debugger stops the timer.

use firmware::application::Bridge as Command;
use model_core::plant::pwm_timer::{
    BACK_EMF_INSTANT, CurrentInstant, PWM_COUNTS, TIMER_CLOCK_HZ, TIMER_DIVIDER, WINDOW_START,
};
use stm32f4xx_hal::pac::{DBGMCU, TIM1};

use super::timing::CORE_HZ;

const _: () = assert!(TIMER_CLOCK_HZ == CORE_HZ);

/// Dead time in cycles of 168 MHz (RM0090, section 17.4.18): (64 + 20) x 2 = 168, that is 1 us.
const DEAD_TIME: u8 = 0b10 << 6 | 20;
const _: () = assert!((64 + (DEAD_TIME as u32 & 0x3f)) * 2 == CORE_HZ / 1_000_000);

/// The bridge.
pub struct Bridge {
    tim: TIM1,
    /// Whether the outputs are on from the next edge on.
    is_enabled: bool,
    /// Whether the control step of this control period has set a command.
    was_commanded: bool,
}

/// Event of TIM1's channels 3 and 4 in the last PWM period of a control period.
pub enum Instant {
    /// The middle of the on time.
    Current,
    /// The coast window has started; the outputs are off.
    WindowStart,
    /// Late in the coast window.
    BackEmf,
}

impl Bridge {
    /// Sets the timer up: outputs off, counter stopped.
    pub fn new(tim: TIM1, debug: &DBGMCU) -> Self {
        // While a debugger halts the program, the motor is not driven and the watchdog does not
        // reset.
        debug.apb2_fz().modify(|_, w| w.dbg_tim1_stop().set_bit());
        debug.apb1_fz().modify(|_, w| {
            w.dbg_iwdg_stop().set_bit().dbg_wwdg_stop().set_bit();
            w.dbg_tim2_stop().set_bit()
        });
        tim.psc().write(|w| w.psc().set(TIMER_DIVIDER as u16 - 1));
        tim.arr().write(|w| w.arr().set((PWM_COUNTS - 1) as u16));
        // Both legs: PWM mode 1 with preload. Channels 3 and 4 have no pin and give the sampling
        // instants: changes of channel 3 take effect at once, those of channel 4 at the next edge.
        tim.ccmr1_output().write(|w| {
            w.oc1m().pwm_mode1().oc1pe().enabled();
            w.oc2m().pwm_mode1().oc2pe().enabled()
        });
        tim.ccmr2_output().write(|w| w.oc4pe().enabled());
        tim.ccr3().write(|w| w.ccr().set(WINDOW_START as u16));
        let current = CurrentInstant::of_on_time(0).count() as u16;
        tim.ccr4().write(|w| w.ccr().set(current));
        tim.ccer().write(|w| {
            w.cc1e().set_bit().cc1ne().set_bit();
            w.cc2e().set_bit().cc2ne().set_bit()
        });
        // Idle levels are low after a reset: all switches open. Lock level 3 protects polarities,
        // idle levels, break, dead time and output modes until the next reset.
        tim.bdtr().write(|w| {
            w.bke()
                .set_bit()
                .bkp()
                .clear_bit()
                .ossi()
                .set_bit()
                .ossr()
                .set_bit();
            w.dtg().set(DEAD_TIME).lock().level3()
        });
        tim.cr1().write(|w| w.arpe().enabled());
        // The preloaded values take effect, which sets UIF.
        tim.egr().write(|w| w.ug().set_bit());
        tim.sr().write(|w| w.uif().clear_bit());
        tim.dier().write(|w| w.uie().set_bit());
        Self {
            tim,
            is_enabled: false,
            was_commanded: false,
        }
    }

    /// Starts the first PWM period.
    pub fn start(&mut self) {
        self.tim.cr1().modify(|_, w| w.cen().enabled());
    }

    /// Sets the state of the bridge from the next edge on.
    pub fn command(&mut self, command: Command) {
        let counts = match command {
            Command::Coast | Command::Brake => 0,
            Command::Driven(compare) => compare.get(),
        };
        self.is_enabled = command != Command::Coast;
        self.was_commanded = true;
        let on = counts.unsigned_abs() as u16;
        let (a, b) = if counts < 0 { (0, on) } else { (on, 0) };
        // All three values take effect at the same edge.
        self.tim.cr1().modify(|_, w| w.udis().set_bit());
        self.tim.ccr1().write(|w| w.ccr().set(a));
        self.tim.ccr2().write(|w| w.ccr().set(b));
        let current = CurrentInstant::of_on_time(on.into()).count() as u16;
        self.tim.ccr4().write(|w| w.ccr().set(current));
        self.tim.cr1().modify(|_, w| w.udis().clear_bit());
    }

    /// Whether the motor is driven or braked.
    pub fn is_on(&self) -> bool {
        self.is_enabled
    }

    /// Starts a control period. If the previous one had no control step, the motor coasts: a stale
    /// duty must not be driven.
    pub fn begin_control_period(&mut self) {
        self.is_enabled &= self.was_commanded;
        self.was_commanded = false;
    }

    /// Starts a PWM period: the outputs follow the command, also after the coast window.
    pub fn begin_pwm_period(&mut self) {
        self.tim.sr().write(|w| w.uif().clear_bit());
        if !self.is_enabled || self.has_tripped() {
            self.off();
            return;
        }
        self.tim.bdtr().modify(|_, w| w.moe().set_bit());
        // The bridge may have tripped between the two lines above.
        if self.has_tripped() {
            self.off();
        }
    }

    /// Enables the interrupts of the sampling instants in this PWM period, the last one of a
    /// control period.
    pub fn enable_sampling_instants(&mut self) {
        self.tim.ccr3().write(|w| w.ccr().set(WINDOW_START as u16));
        self.tim
            .sr()
            .write(|w| w.cc3if().clear_bit().cc4if().clear_bit());
        self.tim
            .dier()
            .modify(|_, w| w.cc3ie().set_bit().cc4ie().set_bit());
    }

    /// The instant of a channel interrupt; at the start of the window the outputs are switched off.
    pub fn take_instant(&mut self) -> Option<Instant> {
        let flags = self.tim.sr().read();
        let enabled = self.tim.dier().read();
        if flags.cc4if().bit() && enabled.cc4ie().bit() {
            self.tim.sr().write(|w| w.cc4if().clear_bit());
            self.tim.dier().modify(|_, w| w.cc4ie().clear_bit());
            return Some(Instant::Current);
        }
        if !(flags.cc3if().bit() && enabled.cc3ie().bit()) {
            return None;
        }
        self.tim.sr().write(|w| w.cc3if().clear_bit());
        if self.tim.ccr3().read().ccr().bits() == WINDOW_START as u16 {
            self.off();
            self.tim
                .ccr3()
                .write(|w| w.ccr().set(BACK_EMF_INSTANT as u16));
            return Some(Instant::WindowStart);
        }
        self.tim.dier().modify(|_, w| w.cc3ie().clear_bit());
        Some(Instant::BackEmf)
    }

    /// Whether the over-current comparator has switched the bridge off since the last call. While
    /// its input is low the flag is set again, and the hardware keeps `MOE` clear.
    pub fn take_trip(&mut self) -> bool {
        let tripped = self.has_tripped();
        if tripped {
            self.tim.sr().write(|w| w.bif().clear_bit());
        }
        tripped
    }

    /// Whether the next PWM period has already started, so that the command takes effect one period
    /// late.
    pub fn is_late(&self) -> bool {
        self.tim.sr().read().uif().bit()
    }

    fn has_tripped(&self) -> bool {
        self.tim.sr().read().bif().bit()
    }

    fn off(&self) {
        self.tim.bdtr().modify(|_, w| w.moe().clear_bit());
    }
}
