//! The options of a run from a command line or a TOML file, with sequences from files.
//!
//! ```toml
//! model = "board"
//! preset = "as-measured"
//! input = "3-2-1-1"
//! duration_s = 4.0
//! pwm = "switched"
//!
//! [set]
//! position_gain = 10.0
//! "input.amplitude_deg" = 5.0
//! ```

mod file;

use std::path::PathBuf;

use model_core::excitation::catalogue::Input;
use model_core::scenario::{self, Request};
use serde::Deserialize;

use crate::{
    error::Error,
    input::{self, Command},
    settings::{ModelKind, PlantKind, Pwm, Settings},
    simulate::Simulation,
    trace::Trace,
};

pub use model_core::scenario::{DEFAULT_EVERY, INPUT_PREFIX};

/// The options of a run, with their defaults in brackets.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Scenario {
    /// The model. It has no default.
    #[serde(deserialize_with = "file::model")]
    pub model: Option<ModelKind>,
    /// The plant of the board (`first-order`).
    #[serde(deserialize_with = "file::plant")]
    pub plant: Option<PlantKind>,
    /// The preset (the model's first).
    #[serde(deserialize_with = "file::preset")]
    pub preset: Option<String>,
    /// The input by name (`pulse`).
    #[serde(deserialize_with = "file::input")]
    pub input: Option<String>,
    /// The input from a file, in place of `input`; in a scenario file, relative to it.
    pub input_file: Option<PathBuf>,
    /// A torque on the load of the bench, from a file; in a scenario file, relative to it.
    pub load_file: Option<PathBuf>,
    /// How long to run, s (as long as the input).
    #[serde(deserialize_with = "file::duration")]
    pub duration_s: Option<f64>,
    /// Ticks of 50 us between rows (20).
    #[serde(deserialize_with = "file::every")]
    pub every: Option<u64>,
    /// Seed of the random numbers (0).
    pub seed: Option<u64>,
    /// How the bridge is switched (`average`).
    #[serde(deserialize_with = "file::pwm")]
    pub pwm: Option<Pwm>,
    /// Parameters by name, set after the preset; of several values for one the last applies.
    #[serde(deserialize_with = "file::set")]
    pub set: Vec<Setting>,
    /// Parameters of `set` that a fit did not determine: the simulator needs their values, the
    /// model of a board does not take them.
    pub undetermined: Vec<String>,
    /// The file that it was read from.
    #[serde(skip)]
    pub path: Option<PathBuf>,
}

/// A value for a parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// Name or symbol; that of a parameter of the input begins with [`INPUT_PREFIX`].
    pub name: String,
    /// The value.
    pub value: f64,
    /// Its line in the scenario file, counted from 1.
    pub line: Option<usize>,
}

impl Setting {
    /// A value that is not from a file.
    pub fn new(name: impl Into<String>, value: f64) -> Self {
        Self {
            name: name.into(),
            value,
            line: None,
        }
    }
}

impl Scenario {
    /// This scenario with the options of `over` in place of its own; parameters are appended.
    pub fn overridden_by(mut self, over: Self) -> Self {
        if over.input.is_some() || over.input_file.is_some() {
            (self.input, self.input_file) = (over.input, over.input_file);
        }
        self.set.extend(over.set);
        Self {
            model: over.model.or(self.model),
            plant: over.plant.or(self.plant),
            preset: over.preset.or(self.preset),
            load_file: over.load_file.or(self.load_file),
            duration_s: over.duration_s.or(self.duration_s),
            every: over.every.or(self.every),
            seed: over.seed.or(self.seed),
            pwm: over.pwm.or(self.pwm),
            path: self.path.or(over.path),
            ..self
        }
    }

    /// Every parameter with its value in this scenario.
    ///
    /// # Errors
    /// As [`Scenario::resolve`].
    pub fn settings(&self) -> Result<Settings, Error> {
        Ok(self.described()?.settings)
    }

    /// What is run, but for the sequences from files.
    ///
    /// # Errors
    /// As [`Scenario::resolve`].
    pub fn described(&self) -> Result<scenario::Scenario, Error> {
        if self.input.is_some() && self.input_file.is_some() {
            let both = "both an input by name and an input file, expected one of them";
            return Err(Error::Conflict(both.into()));
        }
        let mut described = scenario::Scenario::try_new(&Request {
            model: self.model,
            plant: self.plant,
            preset: self.preset.as_deref(),
            input: self.input.as_deref(),
            duration_s: self.duration_s,
            every: self.every,
            seed: self.seed,
            pwm: self.pwm,
        })?;
        for setting in &self.set {
            let name = &setting.name;
            let result = if self.input_file.is_some() && name.starts_with(INPUT_PREFIX) {
                let problem = format!("`{name}` is set, but an input file has no parameters");
                Err(Error::Conflict(problem))
            } else {
                described.set(name, setting.value).map_err(Error::from)
            };
            result.map_err(|error| self.at(setting, error))?;
        }
        if self.load_file.is_some() && self.plant != Some(PlantKind::Drivetrain) {
            let alone = "a load file applies to the plant `bench`, no other has a load";
            return Err(Error::Conflict(alone.into()));
        }
        Ok(described)
    }

    /// The standard input with its parameters; `None` if the command is from a file.
    ///
    /// # Errors
    /// As [`Scenario::resolve`].
    pub fn standard_input(&self) -> Result<Option<Input>, Error> {
        let described = self.described()?;
        Ok(self.input_file.is_none().then_some(described.input))
    }

    /// The run that this scenario describes.
    ///
    /// # Errors
    /// For options and parameters that do not exist, are out of range, or exclude each other; those
    /// of [`input::file::read`].
    pub fn resolve(&self) -> Result<Simulation, Error> {
        let described = self.described()?;
        let (command, natural_ticks, input) = self.command(&described)?;
        let load = self.load_file.as_deref();
        let load = load
            .map(|path| input::file::read(path, &input::file::LOAD))
            .transpose()?;
        let mut simulation = Simulation {
            settings: described.settings,
            command,
            input,
            load,
            ticks: 0,
            every: described.every,
            progress: None,
        };
        // A run of no ticks finds parameters that exclude each other, before any output is made.
        simulation.run(&mut Trace::default())?;
        simulation.ticks = described
            .duration_s
            .map_or(natural_ticks, scenario::run_ticks);
        Ok(simulation)
    }

    /// The error with the location of its setting.
    fn at(&self, setting: &Setting, error: Error) -> Error {
        match (&self.path, setting.line) {
            (Some(path), Some(line)) => Error::At {
                path: path.clone(),
                line,
                error: Box::new(error),
            },
            _ => error,
        }
    }

    /// The command, how many ticks it lasts, and its name.
    fn command(&self, described: &scenario::Scenario) -> Result<(Command, u64, String), Error> {
        let Some(path) = &self.input_file else {
            let input = described.input;
            let ticks = input.duration_ticks()?;
            return Ok((
                Command::Excitation(input.excitation()?),
                ticks,
                input.name().into(),
            ));
        };
        let sequence = input::file::read(path, &input::file::COMMAND)?;
        // The last row of the file is the last of the run.
        let ticks = sequence.last_tick() + 1;
        Ok((
            Command::Sequence(sequence),
            ticks,
            path.display().to_string(),
        ))
    }
}
