//! Excitations that run on the board.

mod logarithmic;
mod settings;

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
    /// What it starts with.
    first: Angle,
}

/// What an excitation adds to the command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sample {
    /// The tick of the excitation.
    pub tick: u64,
    /// What it adds there.
    pub angle: Angle,
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

    /// What it adds at a tick. This may take longer than a control period has time for.
    pub fn sample(&self, tick: u64) -> Sample {
        Sample {
            tick,
            angle: self.excitation.command(tick),
        }
    }
}

/// An excitation on its way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Running {
    run: Run,
    /// The command at its start, which it is added to.
    base: Angle,
    tick: u64,
    /// What has been computed beforehand.
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

    /// The tick whose sample the next control period takes and does not have; none where it has it,
    /// or all of it has been seen.
    pub fn due(&self) -> Option<u64> {
        let has_more = self.tick <= self.run.ticks;
        (has_more && self.ready.tick != self.tick).then_some(self.tick)
    }

    /// Takes what has been computed beforehand.
    pub fn offer(&mut self, sample: Sample) {
        self.ready = sample;
    }

    /// Computes the sample that is due.
    pub fn prepare(&mut self) {
        if let Some(tick) = self.due() {
            self.ready = self.run.sample(tick);
        }
    }

    /// The command of this control period; none once all of it has been seen.
    pub fn next(&mut self) -> Option<Angle> {
        if self.tick > self.run.ticks {
            self.run.more = self.run.more.checked_sub(1)?;
            self.tick = 0;
            self.ready = self.run.sample_at_start();
        }
        // What has not been computed in time, or for another tick, is computed here.
        self.prepare();
        self.tick = self.tick.saturating_add(CONTROL_PERIOD_TICKS);
        Some(self.base.saturating_add(self.ready.angle))
    }

    /// The command at its start.
    pub fn base(&self) -> Angle {
        self.base
    }
}
