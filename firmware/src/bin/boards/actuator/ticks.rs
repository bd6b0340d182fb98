//! PWM periods and ticks by a timer that nobody holds up, and the time that a control step takes.
//!
//! TIM2 runs on the clock of TIM1, also while the processor sleeps, and counts half periods of its
//! PWM. Its 32 bits wrap after 25 days, at a whole number of ticks.

use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use model_core::time::{PWM_PERIODS_PER_CONTROL_PERIOD, PWM_RATE_HZ};

use cortex_m::peripheral::{DCB, DWT};
use firmware::supervisor::Periods;
use stm32f4xx_hal::pac::TIM2;

/// Cycles of the longest control step so far.
#[unsafe(no_mangle)]
static LONGEST_STEP: AtomicU32 = AtomicU32::new(0);

/// Cycles of the longest control step so far.
pub fn longest_step_cycles() -> u32 {
    LONGEST_STEP.load(Relaxed)
}

/// The timer.
pub struct Clock(TIM2);

impl Clock {
    /// Sets the timer up, at rest.
    pub fn new(tim: TIM2) -> Self {
        // Twice in a PWM period, from 84 MHz: 42,000 cycles at 1 kHz.
        const CYCLES: u32 = 84_000_000 / (2 * PWM_RATE_HZ);
        tim.psc().write(|w| w.psc().set((CYCLES - 1) as u16));
        // SAFETY: all 32 bits count.
        tim.arr().write(|w| unsafe { w.bits(u32::MAX) });
        tim.egr().write(|w| w.ug().set_bit());
        Self(tim)
    }

    /// Starts it, right before TIM1: at each of its edges a half period has just been counted.
    pub fn start(&mut self) {
        self.0.cr1().write(|w| w.cen().enabled());
    }

    /// The number of the present PWM period since the first edge, which is 0; it has 31 bits, and wraps.
    pub fn period(&self) -> u32 {
        (self.0.cnt().read().bits() >> 1).wrapping_sub(1)
    }

    /// Which period of the tick that is, and the number of the tick.
    pub fn now(&self) -> (u32, u32) {
        let period = self.period();
        (
            period % PWM_PERIODS_PER_CONTROL_PERIOD,
            period / PWM_PERIODS_PER_CONTROL_PERIOD,
        )
    }
}

/// Finds ticks without a control step, and measures the steps.
#[derive(Default)]
pub struct Ticks {
    periods: Periods,
    began: u32,
}

impl Ticks {
    /// Starts the cycle counter. It rests while the processor sleeps, which it never does in a step.
    pub fn new(mut debug: DCB, mut trace: DWT) -> Self {
        debug.enable_trace();
        trace.enable_cycle_counter();
        Self::default()
    }

    /// The control step of this tick begins: how many ticks went without one.
    pub fn begin(&mut self, tick: u32) -> u8 {
        self.began = DWT::cycle_count();
        self.periods.missed(tick)
    }

    /// It ended.
    pub fn end(&self) {
        let cycles = DWT::cycle_count().wrapping_sub(self.began);
        if cycles > LONGEST_STEP.load(Relaxed) {
            LONGEST_STEP.store(cycles, Relaxed);
        }
    }
}
