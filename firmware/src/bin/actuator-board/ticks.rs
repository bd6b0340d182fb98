//! Ticks that were missed, and the time that a control step takes, by the processor's cycle counter.

use core::sync::atomic::{AtomicU32, Ordering::Relaxed};

use cortex_m::peripheral::{DCB, DWT};

/// Cycles in a tick: 4 ms of 168 MHz.
const TICK: u32 = 672_000;

/// Cycles of the longest control step so far, for whoever asks over the debugger.
static LONGEST_STEP: AtomicU32 = AtomicU32::new(0);

/// Cycles of the longest control step so far.
pub fn longest_step_cycles() -> u32 {
    LONGEST_STEP.load(Relaxed)
}

/// Counts ticks by cycles.
#[derive(Default)]
pub struct Ticks {
    last: Option<u32>,
}

impl Ticks {
    /// Starts the cycle counter, which wraps every 25 s.
    pub fn new(mut debug: DCB, mut trace: DWT) -> Self {
        debug.enable_trace();
        trace.enable_cycle_counter();
        Self::default()
    }

    /// A control step begins: how many should have begun since the last one did.
    pub fn begin(&mut self) -> u8 {
        let now = DWT::cycle_count();
        let last = self.last.replace(now);
        let mut elapsed = last.map_or(TICK, |last| now.wrapping_sub(last));
        let mut missed = 0u8;
        // Half a tick late is late.
        while elapsed > TICK + TICK / 2 {
            elapsed -= TICK;
            missed = missed.saturating_add(1);
        }
        missed
    }

    /// It ended.
    pub fn end(&self) {
        let cycles = self
            .last
            .map_or(0, |began| DWT::cycle_count().wrapping_sub(began));
        if cycles > LONGEST_STEP.load(Relaxed) {
            LONGEST_STEP.store(cycles, Relaxed);
        }
    }
}
