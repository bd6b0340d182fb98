//! Numbers of update periods and control periods, by a timer that no interrupt delays, and the
//! duration of the control steps.
//!
//! TIM2 has the same clock source as TIM1, also while the processor sleeps, and counts half update
//! periods. Its 32 bits wrap at a whole number of control periods, after 25 days at 1 kHz.

use core::sync::atomic::{AtomicU32, Ordering::Relaxed};

use cortex_m::peripheral::{DCB, DWT};
use firmware::supervisor::MissedPeriods;

use super::timing::{APB1_TIMER_HZ, UPDATE_HZ, UPDATE_PERIODS};
use crate::chip::pac::TIM2;

/// Cycles of the longest control step since the reset.
#[unsafe(no_mangle)]
static LONGEST_STEP: AtomicU32 = AtomicU32::new(0);

/// Cycles of the longest control step since the reset.
pub fn longest_step_cycles() -> u32 {
    LONGEST_STEP.load(Relaxed)
}

/// Cycles of the timer's clock in half an update period.
const HALF_PERIOD_CYCLES: u32 = APB1_TIMER_HZ / (2 * UPDATE_HZ);
const _: () = assert!(HALF_PERIOD_CYCLES * 2 * UPDATE_HZ == APB1_TIMER_HZ);
const _: () = assert!(HALF_PERIOD_CYCLES <= 1 << 16, "the prescaler has 16 bits");

/// The counter of update periods.
pub struct PeriodCounter(TIM2);

impl PeriodCounter {
    /// Sets the timer up, stopped.
    pub fn new(tim: TIM2) -> Self {
        tim.psc()
            .write(|w| w.psc().set((HALF_PERIOD_CYCLES - 1) as u16));
        // SAFETY: all 32 bits count.
        tim.arr().write(|w| unsafe { w.bits(u32::MAX) });
        tim.egr().write(|w| w.ug().set_bit());
        Self(tim)
    }

    /// Starts it; call this immediately before TIM1 starts. At each edge of TIM1 the counter has
    /// then just completed a half period.
    pub fn start(&mut self) {
        self.0.cr1().write(|w| w.cen().enabled());
    }

    /// Number of the present update period since the first edge, which has number 0. It has 31 bits
    /// and wraps.
    pub fn period(&self) -> u32 {
        (self.0.cnt().read().bits() >> 1).wrapping_sub(1)
    }

    /// Index of the present update period within its control period.
    pub fn index(&self) -> u32 {
        self.period() % UPDATE_PERIODS
    }

    /// Number of the present control period; it wraps.
    pub fn control_period(&self) -> u32 {
        self.period() / UPDATE_PERIODS
    }
}

/// Detects control periods without a control step, and measures the duration of the steps.
#[derive(Default)]
pub struct StepMonitor {
    periods: MissedPeriods,
    start_cycles: u32,
}

impl StepMonitor {
    /// Starts the cycle counter. It stops while the processor sleeps, which it never does in a
    /// step.
    pub fn new(mut debug: DCB, mut trace: DWT) -> Self {
        debug.enable_trace();
        trace.enable_cycle_counter();
        Self::default()
    }

    /// Starts the step of this control period; returns the number of periods without one before it.
    pub fn begin(&mut self, control_period: u32) -> u8 {
        self.start_cycles = DWT::cycle_count();
        self.periods.missed(control_period)
    }

    /// Ends the step.
    pub fn end(&self) {
        let cycles = DWT::cycle_count().wrapping_sub(self.start_cycles);
        // No other context writes it: the control step is not reentered.
        if cycles > LONGEST_STEP.load(Relaxed) {
            LONGEST_STEP.store(cycles, Relaxed);
        }
    }
}
