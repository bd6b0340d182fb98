//! Excitations that run on the board.

use model_core::{control::units::Angle, excitation::Excitation, time::CONTROL_PERIOD_TICKS};

/// An excitation and how long it runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Run {
    /// The input; it is added to the command at its start.
    pub excitation: Excitation<'static>,
    /// Its length in ticks of `model_core::time`.
    pub ticks: u64,
}

impl Run {
    /// A run until all of it has been seen.
    ///
    /// ```
    /// use firmware::command::excitation::Run;
    /// use model_core::excitation::{Excitation, multistep::Multistep};
    /// let pulse = Multistep::try_pulse(&Default::default()).unwrap();
    /// assert_eq!(Run::once(Excitation::Multistep(pulse)).ticks, 60_000);
    /// ```
    pub fn once(excitation: Excitation<'static>) -> Self {
        Self {
            excitation,
            ticks: excitation.duration_ticks(),
        }
    }
}

/// An excitation on its way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Running {
    run: Run,
    /// The command at its start, which it is added to.
    base: Angle,
    tick: u64,
}

impl Running {
    pub fn new(run: Run, base: Angle) -> Self {
        Self { run, base, tick: 0 }
    }

    /// The command of this control period.
    pub fn next(&mut self) -> Angle {
        let command = self
            .base
            .saturating_add(self.run.excitation.command(self.tick));
        self.tick = self.tick.saturating_add(CONTROL_PERIOD_TICKS);
        command
    }

    /// Whether all of it has been seen.
    pub fn is_over(&self) -> bool {
        self.tick > self.run.ticks
    }
}
