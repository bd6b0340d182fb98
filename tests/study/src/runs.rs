//! All runs of the study, and the recordings in them.

use identification::{Experiment, Hold, Recording};
use indicatif::{ProgressBar, ProgressStyle};
use model_core::{excitation::catalogue::Input, time::TICKS_PER_SECOND};
use rayon::prelude::*;
use virtual_board::run::{Firmware, Options, run};

use crate::{
    Failure,
    bench::{Controller, Load, RUNS, rig},
    link::{HOST, Host, Sample},
};

/// The inputs of the paper, section III.
pub const INPUTS: [&str; 6] = ["pulse", "variable-step", "ramp", "chirp", "sine", "3-2-1-1"];

/// The conditions of the study. The second is the paper's as far as its numbers can be had from one
/// loop; the first is the loop that it prints.
pub const CONDITIONS: [(Controller, Load); 3] = [
    (Controller::Printed, Load::Unloaded),
    (Controller::Retuned, Load::Unloaded),
    (Controller::Retuned, Load::Loaded),
];

/// Where the chirp ends, Hz.
pub const CHIRP_END_HZ: f64 = 6.0;

/// The chirp: what the motor can follow without the whole duty, 2150 deg/s^2 at the most, up to 6
/// Hz. The default, 5 deg up to 10 Hz, the board ends for overload.
const CHIRP: [(&str, f64); 3] = [
    ("amplitude_deg", 1.5),
    ("end_hz", CHIRP_END_HZ),
    ("duration_s", 15.0),
];

/// What is recorded of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rate {
    /// Every control period.
    Hz250,
    /// Every fifth, as the paper's host logged.
    Hz50,
}

impl Rate {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Hz250, Self::Hz50];

    /// Samples per second.
    pub fn hz(self) -> usize {
        250 / self.every()
    }

    fn every(self) -> usize {
        match self {
            Self::Hz250 => 1,
            Self::Hz50 => HOST,
        }
    }
}

/// Which run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key {
    /// How the board was tuned.
    pub controller: Controller,
    /// What it moved.
    pub load: Load,
    /// What was commanded: an index into [`INPUTS`].
    pub input: usize,
    /// Which of the runs, from 1.
    pub run: u64,
}

impl Key {
    /// All runs of the study.
    pub fn all() -> Vec<Self> {
        let mut keys = Vec::new();
        for (controller, load) in CONDITIONS {
            for input in 0..INPUTS.len() {
                keys.extend((1..=RUNS).map(|run| Self {
                    controller,
                    load,
                    input,
                    run,
                }));
            }
        }
        keys
    }

    /// Its name in tables.
    pub fn name(&self) -> String {
        let (controller, load) = (self.controller.name(), self.load.name());
        format!(
            "{controller}, {load}, {}, run {}",
            INPUTS[self.input], self.run
        )
    }

    /// What the host commands, mdeg, each 20 ms.
    fn commands(&self) -> Result<Vec<i32>, Failure> {
        let name = INPUTS[self.input];
        let mut input = Input::named(name).ok_or(Failure::NoInput(name))?;
        for (name, value) in CHIRP.into_iter().filter(|_| name == "chirp") {
            input.set(name, value)?;
        }
        let excitation = input.excitation()?;
        let host_ticks = TICKS_PER_SECOND / 50;
        let periods = input.duration_ticks()? / host_ticks;
        let command = |period: u64| excitation.command(period * host_ticks).to_f64();
        Ok((0..=periods)
            .map(|period| (command(period) * 1e3).round() as i32)
            .collect())
    }
}

/// A run of the board.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// Which one.
    pub key: Key,
    commands_mdeg: Vec<i32>,
    samples: Vec<Sample>,
}

impl Run {
    /// Runs the board's program on the emulated board.
    ///
    /// # Errors
    /// [`Failure`] of a board that does not run or that stops, and of an emulation with gaps.
    pub fn of(firmware: &Firmware, key: Key) -> Result<Self, Failure> {
        let commands_mdeg = key.commands()?;
        let host = Host::new(&key.controller.objects(), commands_mdeg.clone());
        let options = Options {
            rig: rig(key.load, key.run),
            keeps_trace: false,
            ..Options::for_ms(host.duration_ms())
        };
        let finished = run(firmware, options, host)?;
        if !finished.gaps.is_empty() {
            return Err(Failure::Gaps(key.name(), finished.gaps.to_string()));
        }
        let samples = finished.script.samples();
        let samples = samples.map_err(|problem| Failure::Run(key.name(), problem))?;
        Ok(Self {
            key,
            commands_mdeg,
            samples: samples.to_vec(),
        })
    }

    /// The commands, deg, one each 20 ms.
    pub fn commands_deg(&self) -> impl Iterator<Item = f64> {
        self.commands_mdeg
            .iter()
            .map(|mdeg| f64::from(*mdeg) * 1e-3)
    }

    /// Control periods.
    pub fn len(&self) -> usize {
        self.samples.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }

    /// A checksum of commands and angles as the bus carried them: FNV-1a, 64 bits (Fowler, Noll,
    /// Vo).
    pub fn checksum(&self) -> u64 {
        let angles = self.samples.iter().map(|sample| sample.angle_mdeg);
        let numbers = self.commands_mdeg.iter().copied().chain(angles);
        numbers
            .flat_map(i32::to_le_bytes)
            .fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
                (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
            })
    }

    /// What a host keeps of it that logs at this rate.
    pub fn recording(&self, rate: Rate) -> Recording {
        let rows = || self.samples.iter().enumerate().step_by(rate.every());
        let column =
            |of: fn(&Sample) -> f64| rows().map(|(_, sample)| of(sample)).collect::<Vec<_>>();
        let command =
            |(tick, _): (usize, &Sample)| f64::from(self.commands_mdeg[tick / HOST]) * 1e-3;
        Recording {
            name: format!("{} run {}", INPUTS[self.key.input], self.key.run),
            time_s: rows().map(|(tick, _)| tick as f64 / 250.0).collect(),
            command_deg: rows().map(command).collect(),
            angle_deg: column(|t| f64::from(t.angle_mdeg) * 1e-3),
            rate_deg_s: Some(column(|t| f64::from(t.rate_ddeg_s) * 0.1)),
            duty_pct: Some(column(|t| f64::from(t.duty_cpct) * 0.01)),
            current_ma: Some(column(|t| f64::from(t.current_ma))),
            supply_v: Some(column(|t| f64::from(t.supply_mv) * 1e-3)),
            hold: Hold::Zero,
            ..Recording::default()
        }
    }

    /// The recording, ready for identification.
    ///
    /// # Errors
    /// Those of [`Experiment::try_new`].
    pub fn experiment(&self, rate: Rate) -> Result<Experiment, Failure> {
        let recording = self.recording(rate);
        let name = recording.name.clone();
        Experiment::try_new(recording).map_err(|error| Failure::Recording(name, error))
    }
}

/// Does these runs on all cores, in any order; they come back in theirs.
///
/// # Errors
/// The first failure.
pub fn all(firmware: &Firmware, keys: &[Key]) -> Result<Vec<Run>, Failure> {
    let bar = progress(keys.len(), "runs of the board");
    let one = |key: &Key| {
        let run = Run::of(firmware, *key);
        bar.inc(1);
        run
    };
    let runs = keys.par_iter().map(one).collect();
    bar.finish_and_clear();
    runs
}

/// A bar on standard error; nothing where that is no terminal.
pub fn progress(steps: usize, what: &'static str) -> ProgressBar {
    let style = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} {eta}");
    ProgressBar::new(steps as u64)
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        .with_message(what)
}
