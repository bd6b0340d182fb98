//! The runs of the study and their recordings.

use identification::{Experiment, Hold, Recording};
use indicatif::{ProgressBar, ProgressStyle};
use model_core::{
    excitation::catalogue::Input,
    time::{CONTROL_RATE_HZ, TICKS_PER_SECOND},
};
use rayon::prelude::*;
use virtual_board::run::{Firmware, Options, run};

use crate::{
    Failure,
    host::{CONTROL_PERIODS_PER_HOST_PERIOD, Host, Sample, seconds},
    test_bench::{Controller, Load, RUNS, plant_options},
};

/// The inputs of the paper, section III.
pub const INPUTS: [&str; 6] = ["pulse", "variable-step", "ramp", "chirp", "sine", "3-2-1-1"];

/// The conditions of the study. The first is the loop that the paper prints; the second is the one
/// whose responses match the paper's numbers as far as one loop can.
pub const CONDITIONS: [(Controller, Load); 3] = [
    (Controller::Printed, Load::Unloaded),
    (Controller::Retuned, Load::Unloaded),
    (Controller::Retuned, Load::Loaded),
];

/// End frequency of the chirp, Hz.
pub const CHIRP_END_HZ: f64 = 6.0;

/// The chirp: at most 2150 deg/s^2, up to 6 Hz, which the motor follows without saturation of the
/// duty. With the default chirp, 5 deg up to 10 Hz, the board stops by its overload protection.
const CHIRP: [(&str, f64); 3] = [
    ("amplitude_deg", 1.5),
    ("end_hz", CHIRP_END_HZ),
    ("duration_s", 15.0),
];

/// Sample rate of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum SampleRate {
    /// Every control period.
    Hz250,
    /// Every fifth control period, as the paper's host.
    Hz50,
}

impl SampleRate {
    /// Both rates.
    pub const ALL: [Self; 2] = [Self::Hz250, Self::Hz50];

    /// Samples per second.
    pub fn hz(self) -> usize {
        CONTROL_RATE_HZ as usize / self.every()
    }

    fn every(self) -> usize {
        match self {
            Self::Hz250 => 1,
            Self::Hz50 => CONTROL_PERIODS_PER_HOST_PERIOD,
        }
    }
}

/// Identification of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct RunKey {
    /// Gains of the board.
    pub controller: Controller,
    /// Load of the board.
    pub load: Load,
    /// Index of the input in [`INPUTS`].
    pub input: usize,
    /// Number of the run, from 1.
    pub run: u64,
}

impl RunKey {
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

    /// The host's commands, mdeg, one per 20 ms.
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
    /// Its identification.
    pub key: RunKey,
    commands_mdeg: Vec<i32>,
    samples: Vec<Sample>,
}

impl Run {
    /// Runs the board's program on the emulated board.
    ///
    /// # Errors
    /// [`Failure`] if the board does not run or stops, or if the emulation has gaps.
    pub fn of(firmware: &Firmware, key: RunKey) -> Result<Self, Failure> {
        let commands_mdeg = key.commands()?;
        let host = Host::new(&key.controller.objects(), commands_mdeg.clone());
        let options = Options {
            plant: plant_options(key.load, key.run),
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

    /// The commands, deg, one per 20 ms.
    pub fn commands_deg(&self) -> impl Iterator<Item = f64> {
        self.commands_mdeg
            .iter()
            .map(|mdeg| f64::from(*mdeg) * 1e-3)
    }

    /// Number of control periods.
    pub fn len(&self) -> usize {
        self.samples.len()
    }

    /// Whether there is no control period.
    pub fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }

    /// A checksum of commands and angles as transmitted on the bus: FNV-1a, 64 bits (Fowler, Noll,
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

    /// The recording at this sample rate.
    pub fn recording(&self, rate: SampleRate) -> Recording {
        let rows = || self.samples.iter().enumerate().step_by(rate.every());
        let column =
            |of: fn(&Sample) -> f64| rows().map(|(_, sample)| of(sample)).collect::<Vec<_>>();
        let command = |(tick, _): (usize, &Sample)| {
            f64::from(self.commands_mdeg[tick / CONTROL_PERIODS_PER_HOST_PERIOD]) * 1e-3
        };
        Recording {
            name: format!("{} run {}", INPUTS[self.key.input], self.key.run),
            time_s: rows().map(|(tick, _)| seconds(tick)).collect(),
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

    /// The recording as an experiment for identification.
    ///
    /// # Errors
    /// Those of [`Experiment::try_new`].
    pub fn experiment(&self, rate: SampleRate) -> Result<Experiment, Failure> {
        let recording = self.recording(rate);
        let name = recording.name.clone();
        Experiment::try_new(recording).map_err(|error| Failure::Recording(name, error))
    }
}

/// Executes these runs on all cores; the results are in the order of the keys.
///
/// # Errors
/// The first failure.
pub fn all(firmware: &Firmware, keys: &[RunKey]) -> Result<Vec<Run>, Failure> {
    let bar = progress(keys.len(), "runs of the board");
    let one = |key: &RunKey| {
        let run = Run::of(firmware, *key);
        bar.inc(1);
        run
    };
    let runs = keys.par_iter().map(one).collect();
    bar.finish_and_clear();
    runs
}

/// A progress bar on standard error; hidden if that is not a terminal.
pub fn progress(steps: usize, what: &'static str) -> ProgressBar {
    let style = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} {eta}");
    ProgressBar::new(steps as u64)
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        .with_message(what)
}
