//! Excitations that run on the board.

mod logarithmic;
mod settings;

use model_core::{control::units::Angle, excitation::Excitation, time::CONTROL_PERIOD_TICKS};

/// An excitation with its duration and its number of repetitions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Run {
    /// The input; it is added to the command at its start.
    pub excitation: Excitation<'static>,
    /// Its length in ticks of `model_core::time`.
    pub ticks: u64,
    /// Number of further repetitions.
    pub more: u16,
    /// Its value at tick 0.
    first: Angle,
}

/// The value of an excitation at a tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Sample {
    /// The tick of the excitation.
    pub tick: u64,
    /// Angle that it adds to the command.
    pub angle: Angle,
}

impl Sample {
    /// No angle at the start.
    pub const DEFAULT: Self = Self {
        tick: 0,
        angle: Angle::ZERO,
    };
}

impl Run {
    /// An excitation that runs `repetitions` times, at least once. A periodic one continues its
    /// phase from one repetition to the next.
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
                once.saturating_mul(runs.into())
            } else {
                once
            },
            more: if is_periodic {
                0
            } else {
                runs.saturating_sub(1)
            },
            first: excitation.command(0),
        }
    }

    fn sample_at_start(&self) -> Sample {
        Sample {
            tick: 0,
            angle: self.first,
        }
    }

    /// The value at a tick. The computation may take too long for a control step.
    pub fn sample(&self, tick: u64) -> Sample {
        Sample {
            tick,
            angle: self.excitation.command(tick),
        }
    }
}

/// A running excitation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Running {
    run: Run,
    /// The command at its start, to which it is added.
    base: Angle,
    tick: u64,
    /// The sample that was computed in advance.
    ready: Sample,
}

impl Running {
    pub fn new(run: Run, base: Angle) -> Self {
        Self {
            run,
            base,
            tick: 0,
            ready: run.sample_at_start(),
        }
    }

    /// The tick of the next control period if its sample has not been computed yet; `None` if it
    /// has been, or at the end of the excitation.
    pub fn due(&self) -> Option<u64> {
        let has_more = self.tick <= self.run.ticks;
        (has_more && self.ready.tick != self.tick).then_some(self.tick)
    }

    /// Stores a sample that was computed in advance.
    pub fn offer(&mut self, sample: Sample) {
        self.ready = sample;
    }

    /// Computes the sample that is due.
    pub fn prepare(&mut self) {
        if let Some(tick) = self.due() {
            self.ready = self.run.sample(tick);
        }
    }

    /// The command of this control period; `None` after the end of the excitation.
    pub fn next(&mut self) -> Option<Angle> {
        if self.tick > self.run.ticks {
            self.run.more = self.run.more.checked_sub(1)?;
            self.tick = 0;
            self.ready = self.run.sample_at_start();
        }
        // A sample that was not computed in time, or for another tick, is computed here.
        self.prepare();
        self.tick = self.tick.saturating_add(CONTROL_PERIOD_TICKS);
        Some(self.base.saturating_add(self.ready.angle))
    }

    /// The command at its start.
    pub fn base(&self) -> Angle {
        self.base
    }
}
