//! When the watchdog is fed, and why the board started.
//!
//! Every part of the program has to report within its time, counted in control periods. While one
//! of them is late, the watchdog is not fed, and its reset puts the bridge into its safe state: a
//! board that hangs in part is worth no more than one that hangs altogether.
//!
//! [`Supervisor::period`] is called once in each control period, so that a control step that does
//! not run starves the watchdog as well.

use crate::timing::periods;

/// A part of the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Part {
    /// The control step: it reports when it has written the bridge.
    Control = 0,
    /// Frames to and from the bus.
    Bus = 1,
    /// Everything that may wait: parameters, flash, log.
    Background = 2,
}

/// Control periods within which each part has to report.
pub const PATIENCE: [u8; 3] = [1, periods(100) as u8, periods(100) as u8];

/// Whether every part is alive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Supervisor {
    silent: [u8; 3],
    starved: u32,
}

impl Supervisor {
    /// All parts have just reported.
    pub const fn new() -> Self {
        Self {
            silent: [0; 3],
            starved: 0,
        }
    }

    /// A part is alive.
    pub fn report(&mut self, part: Part) {
        if let Some(silent) = self.silent.get_mut(part as usize) {
            *silent = 0;
        }
    }

    /// The parts of these bits are alive, bit n for the part of number n.
    ///
    /// ```
    /// use firmware::supervisor::{Part, Supervisor};
    /// let mut supervisor = Supervisor::new();
    /// supervisor.period();
    /// supervisor.report_all(1 << Part::Control as u8);
    /// assert!(supervisor.period());
    /// ```
    pub fn report_all(&mut self, parts: u8) {
        for (number, silent) in self.silent.iter_mut().enumerate() {
            if parts >> number & 1 == 1 {
                *silent = 0;
            }
        }
    }

    /// Once in each control period: whether the watchdog may be fed.
    ///
    /// ```
    /// use firmware::supervisor::{Part, Supervisor};
    /// let mut supervisor = Supervisor::new();
    /// assert!(supervisor.period());
    /// assert!(!supervisor.period()); // the control step did not report
    /// assert_eq!(supervisor.late(), Some(Part::Control));
    /// ```
    pub fn period(&mut self) -> bool {
        let mut may_feed = true;
        for (silent, patience) in self.silent.iter_mut().zip(&PATIENCE) {
            *silent = silent.saturating_add(1);
            may_feed &= *silent <= *patience;
        }
        self.starved = self.starved.saturating_add(u32::from(!may_feed));
        may_feed
    }

    /// A part that is late.
    pub fn late(&self) -> Option<Part> {
        let parts = [Part::Control, Part::Bus, Part::Background];
        let mut late = parts.into_iter().zip(self.silent.into_iter().zip(PATIENCE));
        late.find(|(_, (silent, patience))| silent > patience)
            .map(|(part, _)| part)
    }

    /// Control periods in which the watchdog was not fed.
    pub fn starved(&self) -> u32 {
        self.starved
    }
}

impl Default for Supervisor {
    fn default() -> Self {
        Self::new()
    }
}

/// Counts control periods and finds those that were missed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Periods {
    next: Option<u32>,
}

impl Periods {
    /// A control period starts whose number is `number`, by a counter that no one can hold up;
    /// returns how many were missed since the last one. The counter may wrap.
    ///
    /// ```
    /// use firmware::supervisor::Periods;
    /// let mut periods = Periods::default();
    /// assert_eq!([7, 8, 11, 12].map(|number| periods.missed(number)), [0, 0, 2, 0]);
    /// ```
    pub fn missed(&mut self, number: u32) -> u8 {
        let missed = self.next.map_or(0, |next| number.wrapping_sub(next));
        self.next = Some(number.wrapping_add(1));
        // One that comes twice has missed nothing.
        if missed > u32::MAX / 2 {
            0
        } else {
            missed.min(u32::from(u8::MAX)) as u8
        }
    }
}

/// Why the processor started.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum ResetCause {
    /// The supply came up, or fell below the threshold of the brown-out reset.
    #[default]
    Power = 0,
    /// The reset pin alone.
    Pin = 1,
    /// The program or a debugger asked for it.
    Software = 2,
    /// The independent or the window watchdog.
    Watchdog = 3,
    /// A low-power mode that the option bytes forbid.
    LowPower = 4,
}

impl ResetCause {
    /// The cause that the flags of RCC_CSR tell (RM0090, section 6.3.21), the most telling where
    /// several stand: each reset pulls the pin too, and a power-up sets the flag of the brown-out.
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
    fn one_late_part_starves_the_watchdog_until_it_reports() {
        for part in [Part::Control, Part::Bus, Part::Background] {
            let mut supervisor = Supervisor::new();
            let patience = PATIENCE[part as usize];
            for period in 0..=u8::MAX {
                for other in [Part::Control, Part::Bus, Part::Background] {
                    if other != part {
                        supervisor.report(other);
                    }
                }
                assert_eq!(supervisor.period(), period < patience, "{part:?}, {period}");
            }
            assert_eq!(supervisor.late(), Some(part));
            supervisor.report(part);
            supervisor.report(Part::Control);
            assert!(supervisor.period());
            assert_eq!(supervisor.starved(), 256 - u32::from(patience));
        }
    }

    #[test]
    fn missed_periods_are_counted_across_the_wrap_and_end_at_255() {
        let mut periods = Periods::default();
        assert_eq!(periods.missed(u32::MAX - 1), 0);
        assert_eq!(periods.missed(1), 2);
        assert_eq!(periods.missed(1), 0);
        assert_eq!(periods.missed(100_000), 255);
    }

    #[test]
    fn without_any_flag_it_was_the_pin() {
        assert_eq!(ResetCause::of_csr(0), ResetCause::Pin);
        assert_eq!(ResetCause::of_csr(1 << 26), ResetCause::Pin);
        assert_eq!(ResetCause::of_csr(1 << 28 | 1 << 26), ResetCause::Software);
    }
}
