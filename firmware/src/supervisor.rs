//! Supervision of the program's tasks by the watchdog, and the cause of the last reset.
//!
//! Every task has to report within its deadline, counted in control periods. While one of them is
//! late, the watchdog is not fed, and its reset opens all switches of the bridge: a board with one
//! hanging task must not continue to drive.
//!
//! [`Supervisor::period`] is called once in each control period, so a missing control step also
//! leads to a watchdog reset.

use crate::timing::periods;

/// A task of the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Task {
    /// The control step: it reports when it has written the bridge.
    Control = 0,
    /// Frames to and from the bus.
    Bus = 1,
    /// Everything that may wait: parameters, flash, log.
    Background = 2,
}

/// Deadlines of the tasks' reports, in control periods, in the order of [`Task`].
pub const DEADLINE_PERIODS: [u8; 3] = [1, periods(100) as u8, periods(100) as u8];

/// Monitors the reports of all tasks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Supervisor {
    periods_since_report: [u8; 3],
    unfed_periods: u32,
}

impl Supervisor {
    /// The state directly after reports of all tasks.
    pub const fn new() -> Self {
        Self {
            periods_since_report: [0; 3],
            unfed_periods: 0,
        }
    }

    /// To be called when a task reports.
    pub fn report(&mut self, task: Task) {
        if let Some(periods_since_report) = self.periods_since_report.get_mut(task as usize) {
            *periods_since_report = 0;
        }
    }

    /// To be called when the tasks of these bits have reported; bit `n` is the task with number
    /// `n`.
    ///
    /// ```
    /// use firmware::supervisor::{Task, Supervisor};
    /// let mut supervisor = Supervisor::new();
    /// supervisor.period();
    /// supervisor.report_all(1 << Task::Control as u8);
    /// assert!(supervisor.period());
    /// ```
    pub fn report_all(&mut self, tasks: u8) {
        self.report_one_of(tasks, Task::Control);
        self.report_one_of(tasks, Task::Bus);
        self.report_one_of(tasks, Task::Background);
    }

    /// Inlined, as [`Self::is_in_time`] is: a loop takes most of the time.
    #[inline(always)]
    fn report_one_of(&mut self, tasks: u8, task: Task) {
        if tasks >> task as u8 & 1 == 1 {
            self.report(task);
        }
    }

    /// To be called once in each control period; returns whether the watchdog may be fed.
    ///
    /// ```
    /// use firmware::supervisor::{Task, Supervisor};
    /// let mut supervisor = Supervisor::new();
    /// assert!(supervisor.period());
    /// assert!(!supervisor.period()); // the control step did not report
    /// assert_eq!(supervisor.late(), Some(Task::Control));
    /// ```
    pub fn period(&mut self) -> bool {
        // All three are counted, late or not.
        let may_feed = self.is_in_time(Task::Control)
            & self.is_in_time(Task::Bus)
            & self.is_in_time(Task::Background);
        self.unfed_periods = self.unfed_periods.saturating_add(u32::from(!may_feed));
        may_feed
    }

    /// Counts a control period of a task; returns whether it is not late.
    #[inline(always)]
    fn is_in_time(&mut self, task: Task) -> bool {
        let periods_since_report = &mut self.periods_since_report[task as usize];
        *periods_since_report = periods_since_report.saturating_add(1);
        *periods_since_report <= DEADLINE_PERIODS[task as usize]
    }

    /// The first task that is late, if any.
    pub fn late(&self) -> Option<Task> {
        let tasks = [Task::Control, Task::Bus, Task::Background];
        let mut late = tasks
            .into_iter()
            .zip(self.periods_since_report.into_iter().zip(DEADLINE_PERIODS));
        late.find(|(_, (periods_since_report, deadline))| periods_since_report > deadline)
            .map(|(task, _)| task)
    }

    /// Control periods in which the watchdog was not fed.
    pub fn unfed_periods(&self) -> u32 {
        self.unfed_periods
    }
}

impl Default for Supervisor {
    fn default() -> Self {
        Self::new()
    }
}

/// Detects missed control periods.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct MissedPeriods {
    next: Option<u32>,
}

impl MissedPeriods {
    /// To be called at the start of control period `number`, which is counted by a free-running
    /// timer; returns the number of periods missed since the last call. The number may wrap.
    ///
    /// ```
    /// use firmware::supervisor::MissedPeriods;
    /// let mut periods = MissedPeriods::default();
    /// assert_eq!([7, 8, 11, 12].map(|number| periods.missed(number)), [0, 0, 2, 0]);
    /// ```
    pub fn missed(&mut self, number: u32) -> u8 {
        let missed = self.next.map_or(0, |next| number.wrapping_sub(next));
        self.next = Some(number.wrapping_add(1));
        // A repeated number is not a missed period.
        if missed > u32::MAX / 2 {
            0
        } else {
            missed.min(u32::from(u8::MAX)) as u8
        }
    }
}

/// Cause of the last reset.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum ResetCause {
    /// The supply came up, or fell below the threshold of the brown-out reset.
    #[default]
    Power = 0,
    /// The reset pin alone.
    Pin = 1,
    /// Requested by the program or a debugger.
    Software = 2,
    /// The independent or the window watchdog.
    Watchdog = 3,
    /// A low-power mode that the option bytes forbid.
    LowPower = 4,
}

impl ResetCause {
    /// The cause by the flags of RCC_CSR (RM0090, section 6.3.21), the most specific one if several
    /// are set: each reset also pulls the reset pin, and a power-up also sets the brown-out flag.
    ///
    /// ```
    /// use firmware::supervisor::ResetCause;
    /// assert_eq!(ResetCause::of_csr(1 << 29 | 1 << 26), ResetCause::Watchdog);
    /// assert_eq!(ResetCause::of_csr(0x0e00_0000), ResetCause::Power);
    /// ```
    pub const fn of_csr(csr: u32) -> Self {
        const BROWN_OUT_OR_POWER: u32 = 1 << 25 | 1 << 27;
        const SOFTWARE: u32 = 1 << 28;
        const WATCHDOGS: u32 = 1 << 29 | 1 << 30;
        const LOW_POWER: u32 = 1 << 31;
        if csr & WATCHDOGS != 0 {
            Self::Watchdog
        } else if csr & SOFTWARE != 0 {
            Self::Software
        } else if csr & LOW_POWER != 0 {
            Self::LowPower
        } else if csr & BROWN_OUT_OR_POWER != 0 {
            Self::Power
        } else {
            Self::Pin
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_late_task_stops_the_feeding_until_it_reports() {
        for task in [Task::Control, Task::Bus, Task::Background] {
            let mut supervisor = Supervisor::new();
            let deadline = DEADLINE_PERIODS[task as usize];
            for period in 0..=u8::MAX {
                for other in [Task::Control, Task::Bus, Task::Background] {
                    if other != task {
                        supervisor.report(other);
                    }
                }
                assert_eq!(supervisor.period(), period < deadline, "{task:?}, {period}");
            }
            assert_eq!(supervisor.late(), Some(task));
            supervisor.report(task);
            supervisor.report(Task::Control);
            assert!(supervisor.period());
            assert_eq!(supervisor.unfed_periods(), 256 - u32::from(deadline));
        }
    }

    #[test]
    fn missed_periods_are_counted_across_the_wrap_and_end_at_255() {
        let mut periods = MissedPeriods::default();
        assert_eq!(periods.missed(u32::MAX - 1), 0);
        assert_eq!(periods.missed(1), 2);
        assert_eq!(periods.missed(1), 0);
        assert_eq!(periods.missed(100_000), 255);
    }

    #[test]
    fn without_any_flag_the_cause_is_the_reset_pin() {
        assert_eq!(ResetCause::of_csr(0), ResetCause::Pin);
        assert_eq!(ResetCause::of_csr(1 << 26), ResetCause::Pin);
        assert_eq!(ResetCause::of_csr(1 << 28 | 1 << 26), ResetCause::Software);
    }
}
