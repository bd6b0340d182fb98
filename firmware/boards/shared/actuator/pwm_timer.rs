//! TIM1 as the timer of the H-bridge: two complementary legs, PWM, dead time, break input, and the
//! instants at which current and back-EMF are sampled.
//!
//! Its edges are the update events, in which preloaded values take effect: with a repetition
//! counter above zero one in several PWM periods.
//!
//! The outputs are off, with all four switches open, while `MOE` is clear (RM0090, table 95, with
//! `OSSI` set: driven to their idle levels, which are low; RM0433, section 38.3.15, alike). `MOE`
//! is cleared by any reset, in hardware by a low level at `BKIN`, and while a debugger stops the
//! timer.

use drivers::bridge::{Compare, PwmTimer};
use model_core::control::pwm_timer::{
    BACK_EMF_INSTANT, CurrentInstant, PWM_COUNTS, TIMER_CLOCK_HZ, TIMER_DIVIDER, WINDOW_START,
};
use model_core::time::PWM_PERIODS_PER_UPDATE;

use super::timing::TIM1_HZ;
use crate::chip::pac::TIM1;

const _: () = assert!(TIMER_CLOCK_HZ == TIM1_HZ);

/// Dead time in cycles of 168 MHz (RM0090, section 17.4.18): (64 + 20) x 2 = 168, that is 1 us.
const DEAD_TIME: u8 = 0b10 << 6 | 20;
const _: () = assert!((64 + (DEAD_TIME as u32 & 0x3f)) * 2 == TIM1_HZ / 1_000_000);

/// Counts of the timer in a PWM period, and thus of the instants in theirs.
const PERIOD: u32 = PWM_COUNTS as u32;
const WINDOW_COUNT: u16 = (WINDOW_START % PERIOD) as u16;
const BACK_EMF_COUNT: u16 = (BACK_EMF_INSTANT % PERIOD) as u16;

/// Matches of channel 3 between the start of the window and the sample of the back-EMF: one in each
/// PWM period. In the period of the window's start there is one if the count is still to come.
const SKIPPED_MATCHES: u32 = {
    let periods = BACK_EMF_INSTANT / PERIOD - WINDOW_START / PERIOD;
    if BACK_EMF_COUNT > WINDOW_COUNT {
        periods
    } else {
        periods - 1
    }
};
const _: () = assert!(
    WINDOW_START < PERIOD,
    "the window starts in the first PWM period"
);

const _: () = assert!(
    BACK_EMF_COUNT != WINDOW_COUNT,
    "the count distinguishes them"
);

/// The most interrupts of the channels in a control period: the sample of the current, the start of
/// the window, and the matches up to the sample of the back-EMF.
pub const MOST_INSTANTS: u32 = 3 + SKIPPED_MATCHES;

/// The timer.
pub struct BridgeTimer {
    tim: TIM1,
    /// Matches of channel 3 since the start of the window.
    skipped_matches: u32,
}

/// Event of TIM1's channels 3 and 4 in the last update period of a control period.
pub enum Instant {
    /// The middle of the on time.
    Current,
    /// The coast window has started; the outputs are off.
    WindowStart,
    /// Late in the coast window.
    BackEmf,
}

impl BridgeTimer {
    /// Sets the timer up: outputs off, counter stopped. A debugger that halts the program stops the
    /// timer.
    pub fn new(tim: TIM1) -> Self {
        tim.psc().write(|w| w.psc().set(TIMER_DIVIDER as u16 - 1));
        tim.arr().write(|w| w.arr().set((PWM_COUNTS - 1) as u16));
        // The edges of this module are the update events: one in so many PWM periods.
        tim.rcr()
            .write(|w| w.rep().set((PWM_PERIODS_PER_UPDATE - 1) as _));
        // Both legs: PWM mode 1 with preload. Channels 3 and 4 have no pin and give the sampling
        // instants: changes of channel 3 take effect at once, those of channel 4 at the next edge.
        tim.ccmr1_output().write(|w| {
            w.oc1m().pwm_mode1().oc1pe().enabled();
            w.oc2m().pwm_mode1().oc2pe().enabled()
        });
        tim.ccmr2_output().write(|w| w.oc4pe().enabled());
        tim.ccr3().write(|w| w.ccr().set(WINDOW_COUNT));
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
            skipped_matches: 0,
        }
    }

    /// Starts the first update period.
    pub fn start(&mut self) {
        self.set_control(true, false);
    }

    /// Whether the counter runs, and whether preloaded values wait at an edge.
    fn set_control(&mut self, is_running: bool, waits: bool) {
        self.tim
            .cr1()
            .write(|w| w.arpe().enabled().udis().bit(waits).cen().bit(is_running));
    }

    /// Acknowledges the interrupt of an edge.
    pub fn acknowledge_edge(&mut self) {
        self.tim.sr().write(|w| w.uif().clear_bit());
    }

    /// Whether the next update period has already started, so that the command takes effect one
    /// period late.
    pub fn is_late(&self) -> bool {
        self.tim.sr().read().uif().bit()
    }

    /// Enables the interrupts of the sampling instants in this update period, the last one of a
    /// control period: that of the current, and those of the coast window if there is one.
    #[inline]
    pub fn enable_sampling_instants(&mut self, has_window: bool) {
        self.tim.ccr3().write(|w| w.ccr().set(WINDOW_COUNT));
        self.skipped_matches = 0;
        self.tim
            .sr()
            .write(|w| w.cc3if().clear_bit().cc4if().clear_bit());
        self.tim
            .dier()
            .modify(|_, w| w.cc3ie().bit(has_window).cc4ie().set_bit());
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
        if self.tim.ccr3().read().ccr().bits() == WINDOW_COUNT {
            self.set_outputs(false);
            self.tim.ccr3().write(|w| w.ccr().set(BACK_EMF_COUNT));
            return Some(Instant::WindowStart);
        }
        if SKIPPED_MATCHES != 0 && self.skipped_matches != SKIPPED_MATCHES {
            self.skipped_matches += 1;
            return None;
        }
        self.tim.dier().modify(|_, w| w.cc3ie().clear_bit());
        Some(Instant::BackEmf)
    }
}

impl PwmTimer for BridgeTimer {
    #[inline]
    fn set_compare(&mut self, compare: Compare) {
        // All three values take effect at the same edge. The register is written whole: a read that
        // fails changes no bit but the enable, and the watchdog detects a counter that has stopped.
        let is_running = self.tim.cr1().read().cen().bit();
        self.set_control(is_running, true);
        self.tim.ccr1().write(|w| w.ccr().set(compare.leg_a));
        self.tim.ccr2().write(|w| w.ccr().set(compare.leg_b));
        self.tim.ccr4().write(|w| w.ccr().set(compare.sample));
        self.set_control(is_running, false);
    }

    #[inline]
    fn set_outputs(&mut self, are_on: bool) {
        self.tim.bdtr().modify(|_, w| w.moe().bit(are_on));
    }

    fn are_outputs_on(&self) -> bool {
        self.tim.bdtr().read().moe().bit()
    }

    #[inline]
    fn has_tripped(&self) -> bool {
        self.tim.sr().read().bif().bit()
    }

    /// While the input is low the flag is set again, and the hardware keeps `MOE` clear.
    #[inline]
    fn clear_trip(&mut self) {
        self.tim.sr().write(|w| w.bif().clear_bit());
    }
}
