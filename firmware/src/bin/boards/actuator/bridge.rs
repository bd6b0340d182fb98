//! TIM1 and the bridge behind it: two complementary legs, 1 kHz, dead time, hardware over-current trip.
//!
//! The leg of the voltage's sign is switched, the other one's low side is on: the motor is driven
//! for the share of the period that the compare value names, and braked for the rest.
//!
//! The outputs are off, all four switches open, while `MOE` is clear (RM0090, table 95, with `OSSI`
//! set: driven to their idle levels, which are low). `MOE` is clear after any reset, by a low level
//! at `BKIN` without any help of the program, and while a debugger holds the timer.

use firmware::application::Bridge as Command;
use model_core::plant::pwm_timer::{COUNTS_PER_US, PWM_COUNTS, TIMER_DIVIDER};
use stm32f4xx_hal::pac::{DBGMCU, TIM1};

/// Where the coast window opens: the last 100 us of the last period of a tick.
pub const WINDOW_OPENS: u16 = PWM_COUNTS as u16 - counts(100);
/// Where the back-EMF is sampled: 75 us later, with the winding's current gone.
pub const BACK_EMF_SAMPLED: u16 = WINDOW_OPENS + counts(75);
/// The earliest instant for a sample of the current, 10 us after the edge: past the interrupt that
/// asks for it. Shorter on times are sampled there, in the slow decay behind them.
const CURRENT_EARLIEST: u16 = counts(10);
/// Register value of the timer's divider.
const PRESCALER: u16 = TIMER_DIVIDER as u16 - 1;

/// Counts of the timer in so many microseconds.
const fn counts(us: u32) -> u16 {
    (us * COUNTS_PER_US) as u16
}
/// Dead time in 1/168 us (RM0090, section 17.4.18): (64 + 20) x 2 = 168, hence 1 us.
const DEAD_TIME: u8 = 0b10 << 6 | 20;

/// The bridge.
pub struct Bridge {
    tim: TIM1,
    /// Whether the outputs are on from the next edge on.
    wanted: bool,
    /// Whether the control step of this tick has spoken.
    was_commanded: bool,
}

/// What the timer asks for in the coast window and before it.
pub enum Instant {
    /// The middle of the on time.
    Current,
    /// The window opened; the outputs are off.
    Opened,
    /// Late in the window.
    BackEmf,
}

impl Bridge {
    /// Sets the timer up; outputs off, counter at rest.
    pub fn new(tim: TIM1, debug: &DBGMCU) -> Self {
        // A halted program must not leave a motor driven, nor be bitten by the watchdog.
        debug.apb2_fz().modify(|_, w| w.dbg_tim1_stop().set_bit());
        debug
            .apb1_fz()
            .modify(|_, w| w.dbg_iwdg_stop().set_bit().dbg_tim2_stop().set_bit());
        tim.psc().write(|w| w.psc().set(PRESCALER));
        tim.arr().write(|w| w.arr().set((PWM_COUNTS - 1) as u16));
        // Both legs: PWM mode 1 with preload. Channels 3 and 4 have no pin: they mark instants,
        // channel 3 at once, channel 4 from the next edge.
        tim.ccmr1_output().write(|w| {
            w.oc1m().pwm_mode1().oc1pe().enabled();
            w.oc2m().pwm_mode1().oc2pe().enabled()
        });
        tim.ccmr2_output().write(|w| w.oc4pe().enabled());
        tim.ccr3().write(|w| w.ccr().set(WINDOW_OPENS));
        tim.ccr4().write(|w| w.ccr().set(CURRENT_EARLIEST));
        tim.ccer().write(|w| {
            w.cc1e().set_bit().cc1ne().set_bit();
            w.cc2e().set_bit().cc2ne().set_bit()
        });
        // Idle levels are low as reset left them: all switches open. Locked at level 3, nothing
        // changes polarities, idle levels, break, dead time and output modes until the next reset.
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
        // The preloaded values come into force, and that sets UIF.
        tim.egr().write(|w| w.ug().set_bit());
        tim.sr().write(|w| w.uif().clear_bit());
        tim.dier().write(|w| w.uie().set_bit());
        Self {
            tim,
            wanted: false,
            was_commanded: false,
        }
    }

    /// Starts the first period.
    pub fn start(&mut self) {
        self.tim.cr1().modify(|_, w| w.cen().enabled());
    }

    /// What the bridge shall do from the next edge on.
    pub fn command(&mut self, command: Command) {
        let counts = match command {
            Command::Coast | Command::Brake => 0,
            Command::Driven(compare) => compare.get(),
        };
        self.wanted = command != Command::Coast;
        self.was_commanded = true;
        let on = counts.unsigned_abs() as u16;
        let (a, b) = if counts < 0 { (0, on) } else { (on, 0) };
        // All three come into force at the same edge.
        self.tim.cr1().modify(|_, w| w.udis().set_bit());
        self.tim.ccr1().write(|w| w.ccr().set(a));
        self.tim.ccr2().write(|w| w.ccr().set(b));
        let middle = if on < 2 * CURRENT_EARLIEST {
            CURRENT_EARLIEST
        } else {
            on / 2
        };
        self.tim.ccr4().write(|w| w.ccr().set(middle));
        self.tim.cr1().modify(|_, w| w.udis().clear_bit());
    }

    /// A tick begins. If the one before had no control step, the motor coasts from now on, for an old
    /// duty is nobody's decision.
    pub fn tick_began(&mut self) {
        self.wanted &= self.was_commanded;
        self.was_commanded = false;
    }

    /// A period has begun: the outputs go to what was commanded, out of the coast window too.
    pub fn period_began(&mut self) {
        self.tim.sr().write(|w| w.uif().clear_bit());
        if !self.wanted || self.has_tripped() {
            self.off();
            return;
        }
        self.tim.bdtr().modify(|_, w| w.moe().set_bit());
        // A trip between the look at its flag and the line above.
        if self.has_tripped() {
            self.off();
        }
    }

    /// In the last period of a tick: asks for the sample of the current, the window and what is
    /// sampled in it.
    pub fn open_window_in_this_period(&mut self) {
        self.tim.ccr3().write(|w| w.ccr().set(WINDOW_OPENS));
        self.tim
            .sr()
            .write(|w| w.cc3if().clear_bit().cc4if().clear_bit());
        self.tim
            .dier()
            .modify(|_, w| w.cc3ie().set_bit().cc4ie().set_bit());
    }

    /// Which instant an interrupt of the channels stands for.
    pub fn instant(&mut self) -> Option<Instant> {
        let flags = self.tim.sr().read();
        let asked = self.tim.dier().read();
        if flags.cc4if().bit() && asked.cc4ie().bit() {
            self.tim.sr().write(|w| w.cc4if().clear_bit());
            self.tim.dier().modify(|_, w| w.cc4ie().clear_bit());
            return Some(Instant::Current);
        }
        if !(flags.cc3if().bit() && asked.cc3ie().bit()) {
            return None;
        }
        self.tim.sr().write(|w| w.cc3if().clear_bit());
        if self.tim.ccr3().read().ccr().bits() == WINDOW_OPENS {
            self.off();
            self.tim.ccr3().write(|w| w.ccr().set(BACK_EMF_SAMPLED));
            return Some(Instant::Opened);
        }
        self.tim.dier().modify(|_, w| w.cc3ie().clear_bit());
        Some(Instant::BackEmf)
    }

    /// Whether the over-current comparator switched the bridge off since it was asked last. While its
    /// input stays low the flag comes back, and the hardware refuses `MOE`.
    pub fn take_trip(&mut self) -> bool {
        let tripped = self.has_tripped();
        if tripped {
            self.tim.sr().write(|w| w.bif().clear_bit());
        }
        tripped
    }

    /// Whether the next period has begun, and with it the time for what was commanded too late.
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
