//! Feeds the watchdog while all parts of the program are alive, and monitors the control steps.

use core::sync::atomic::{AtomicU8, AtomicU32, Ordering::Relaxed};

use cortex_m::peripheral::{DCB, DWT};
use firmware::supervisor::{Supervisor, Task};

use super::{timebase::StepMonitor, window_watchdog::WindowWatchdog};
use crate::{
    board::watchdog::Watchdog,
    chip::pac::{IWDG, WWDG},
};

/// Liveness flags, one bit for each task: set by the interrupt of the task, taken by the control
/// step.
static LIVENESS: AtomicU8 = AtomicU8::new(0);

/// Reports that a task is alive.
pub fn report_alive(task: Task) {
    LIVENESS.fetch_or(1 << task as u8, Relaxed);
}

/// Control periods since the reset in which a task was late.
static STARVED_PERIODS: AtomicU32 = AtomicU32::new(0);

/// Control periods since the reset in which a task was late.
pub fn starved_periods() -> u32 {
    STARVED_PERIODS.load(Relaxed)
}

/// Watchdogs, liveness of the parts, and duration of the control steps.
pub struct WatchdogSupervisor {
    supervisor: Supervisor,
    watchdog: Watchdog,
    window_watchdog: WindowWatchdog,
    steps: StepMonitor,
    /// Whether control periods were missed before this step.
    has_missed: bool,
}

impl WatchdogSupervisor {
    /// Starts the watchdog and the cycle counter; the window watchdog starts with the first control
    /// step.
    pub fn start((watchdog, window): (IWDG, WWDG), debug: DCB, trace: DWT) -> Self {
        Self {
            supervisor: Supervisor::new(),
            watchdog: Watchdog::start(watchdog),
            window_watchdog: WindowWatchdog::new(window),
            steps: StepMonitor::new(debug, trace),
            has_missed: false,
        }
    }

    /// Feeds the watchdog before the first control step.
    pub fn feed(&mut self) {
        self.watchdog.feed();
    }

    /// Starts the step of this control period; returns the number of periods without one before it.
    pub fn begin_step(&mut self, control_period: u32) -> u8 {
        let missed = self.steps.begin(control_period);
        self.has_missed = missed > 0;
        missed
    }

    /// Ends the step and feeds the watchdogs if all parts are alive, the window watchdog only after
    /// a step in its time: the step after a late one comes too early for its window.
    pub fn end_step(&mut self, is_late: bool) {
        report_alive(Task::Control);
        self.supervisor.report_all(LIVENESS.swap(0, Relaxed));
        if self.supervisor.period() {
            self.watchdog.feed();
            if !is_late && !self.has_missed {
                self.window_watchdog.feed();
            }
        }
        self.steps.end();
        STARVED_PERIODS.store(self.supervisor.unfed_periods(), Relaxed);
    }
}
