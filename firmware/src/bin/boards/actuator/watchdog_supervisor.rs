//! Feeds the watchdog while all parts of the program are alive, and monitors the control steps.

use core::sync::atomic::{AtomicU8, Ordering::Relaxed};

use cortex_m::peripheral::{DCB, DWT};
use firmware::supervisor::{Supervisor, Task};
use stm32f4xx_hal::pac::IWDG;

use super::timebase::StepMonitor;
use crate::board::watchdog::Watchdog;

/// Liveness flags, one bit for each task: set by the interrupt of the task, taken by the control
/// step.
static LIVENESS: AtomicU8 = AtomicU8::new(0);

/// Reports that a task is alive.
pub fn report_alive(task: Task) {
    LIVENESS.fetch_or(1 << task as u8, Relaxed);
}

/// Watchdog, liveness of the parts, and duration of the control steps.
pub struct WatchdogSupervisor {
    supervisor: Supervisor,
    watchdog: Watchdog,
    steps: StepMonitor,
}

impl WatchdogSupervisor {
    /// Starts the watchdog and the cycle counter.
    pub fn start(watchdog: IWDG, debug: DCB, trace: DWT) -> Self {
        Self {
            supervisor: Supervisor::new(),
            watchdog: Watchdog::start(watchdog),
            steps: StepMonitor::new(debug, trace),
        }
    }

    /// Starts the step of this control period; returns the number of periods without one before it.
    pub fn begin_step(&mut self, control_period: u32) -> u8 {
        self.steps.begin(control_period)
    }

    /// Ends the step and feeds the watchdog if all parts are alive. Returns the number of control
    /// periods since the reset in which a task was late.
    pub fn end_step(&mut self) -> u32 {
        report_alive(Task::Control);
        self.supervisor.report_all(LIVENESS.swap(0, Relaxed));
        if self.supervisor.period() {
            self.watchdog.feed();
        }
        self.steps.end();
        self.supervisor.unfed_periods()
    }
}
