//! Excitations that run on the board.

mod logarithmic;
mod settings;

pub use settings::ExcitationSettings;

use model_core::{control::units::Angle, excitation::Excitation, time::CONTROL_PERIOD_TICKS};

/// An excitation, how long it lasts and how often it runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Run {
    /// The input; it is added to the command at its start.
    pub excitation: Excitation<'static>,
    /// Its length in ticks of `model_core::time`.
    pub ticks: u64,
    /// How often it starts anew after that.
    pub more: u16,
}

impl Run {
    /// So many runs until all of it has been seen, one at the least. What repeats itself goes on
    /// without a seam.
    ///
    /// ```
    /// use firmware::command::excitation::Run;
    /// use model_core::excitation::{Excitation, multistep::Multistep};
    /// let pulse = Multistep::try_pulse(&Default::default()).unwrap();
    /// let run = Run::new(Excitation::Multistep(pulse), 3);
    /// assert_eq!((run.ticks, run.more), (60_000, 2));
    /// ```
    pub fn new(excitation: Excitation<'static>, repetitions: u16) -> Self {
        let once = excitation.duration_ticks();
        let is_periodic = matches!(
            excitation,
            Excitation::Sine(_) | Excitation::Prbs(_) | Excitation::Multisine(_)
        );
        let runs = repetitions.max(1);
        Self {
            excitation,
            ticks: if is_periodic {
                once.saturating_mul(u64::from(runs))
            } else {
                once
            },
            more: if is_periodic {
                0
            } else {
                runs.saturating_sub(1)
            },
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

    /// The command of this control period; none once all of it has been seen.
    pub fn next(&mut self) -> Option<Angle> {
        if self.tick > self.run.ticks {
            self.run.more = self.run.more.checked_sub(1)?;
            self.tick = 0;
        }
        let command = self.run.excitation.command(self.tick);
        self.tick = self.tick.saturating_add(CONTROL_PERIOD_TICKS);
        Some(self.base.saturating_add(command))
    }

    /// The command at its start.
    pub fn base(&self) -> Angle {
        self.base
    }
}
