//! What to simulate, as people say it: on a command line, in a TOML file, or both.
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

mod checks;
mod file;

use std::path::PathBuf;

use model_core::{excitation::catalogue::Input, named::Named, time::ticks};
use serde::Deserialize;

use crate::{
    error::Error,
    input::{self, Command},
    settings::{self, ModelKind, PlantKind, Pwm, Settings},
    simulate::Simulation,
    trace::Trace,
};

/// Ticks between rows unless somebody says otherwise: 1 ms.
pub const DEFAULT_EVERY: u64 = 20;

/// What stands before the name of a parameter of the input.
pub const INPUT_PREFIX: &str = "input.";

/// What to simulate. What is left out has its default, given in brackets.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Scenario {
    /// The model. It must be given.
    #[serde(deserialize_with = "file::named")]
    pub model: Option<ModelKind>,
    /// The plant behind the board (`first-order`).
    #[serde(deserialize_with = "file::named")]
    pub plant: Option<PlantKind>,
    /// The preset (the model's first).
    #[serde(deserialize_with = "file::preset")]
    pub preset: Option<String>,
    /// The input by name (`pulse`).
    #[serde(deserialize_with = "file::input")]
    pub input: Option<String>,
    /// The input from a file, in place of `input`; in a scenario file, relative to it.
    pub input_file: Option<PathBuf>,
    /// A torque on the load of the bench from a file; in a scenario file, relative to it.
    pub load_file: Option<PathBuf>,
    /// How long to run, s (as long as the input).
    #[serde(deserialize_with = "file::duration")]
    pub duration_s: Option<f64>,
    /// Ticks of 50 us between rows (20).
    #[serde(deserialize_with = "file::every")]
    pub every: Option<u64>,
    /// Seed of all that is random (0).
    pub seed: Option<u64>,
    /// How the bridge is switched (`average`).
    #[serde(deserialize_with = "file::named")]
    pub pwm: Option<Pwm>,
    /// Parameters by name, after the preset; of several values for one the last counts.
    #[serde(deserialize_with = "file::set")]
    pub set: Vec<Setting>,
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
    /// The line of the scenario file that says so, counted from 1.
    pub line: Option<usize>,
}

impl Setting {
    /// A value that stands in no file.
    pub fn new(name: impl Into<String>, value: f64) -> Self {
        Self {
            name: name.into(),
            value,
            line: None,
        }
    }

    fn name_in_input(&self) -> Option<&str> {
        self.name.strip_prefix(INPUT_PREFIX)
    }
}

impl Scenario {
    /// This scenario with everything that `over` gives in its place.
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

    /// Every parameter with the value that this scenario gives it.
    ///
    /// # Errors
    /// As [`Scenario::resolve`].
    pub fn settings(&self) -> Result<Settings, Error> {
        let model = self.model.ok_or_else(|| {
            let names = ModelKind::NAMES.join(", ");
            Error::Conflict(format!("no model, expected one of {names}"))
        })?;
        if self.plant.is_some() && model != ModelKind::Board {
            return Err(Error::Conflict(format!(
                "a plant goes with the model `board`, `{model}` has none"
            )));
        }
        let mut settings = Settings::new(model, self.plant.unwrap_or(PlantKind::FirstOrder));
        settings.pwm = self.pwm.unwrap_or(settings.pwm);
        settings.seed = self.seed.unwrap_or(settings.seed);
        if let Some(preset) = &self.preset {
            settings::apply(&mut settings, preset)?;
        }
        for setting in self.set.iter().filter(|s| s.name_in_input().is_none()) {
            let result = settings::set(&mut settings, &setting.name, setting.value);
            result.map_err(|error| self.at(setting, error))?;
        }
        if self.load_file.is_some() && self.plant != Some(PlantKind::Drivetrain) {
            let alone = "a load file goes with the plant `bench`, no other has a load";
            return Err(Error::Conflict(alone.into()));
        }
        Ok(settings)
    }

    /// The run that this scenario describes.
    ///
    /// # Errors
    /// [`Error::UnknownName`], [`Error::Parameter`], [`Error::Option`] or [`Error::Conflict`] for
    /// what does not exist, is out of range or does not go together; those of
    /// [`input::file::read`].
    pub fn resolve(&self) -> Result<Simulation, Error> {
        let settings = self.settings()?;
        let (command, natural_ticks, input) = self.command()?;
        let ticks = match self.duration_s {
            None => natural_ticks,
            Some(duration_s) => ticks(checks::duration(duration_s)?).max(1),
        };
        let every = checks::every(self.every.unwrap_or(DEFAULT_EVERY))?;
        let load = self.load_file.as_deref();
        let load = load
            .map(|path| input::file::read(path, &input::file::LOAD))
            .transpose()?;
        let mut simulation = Simulation {
            settings,
            command,
            input,
            load,
            ticks: 0,
            every,
        };
        // A run of no ticks finds parameters that do not go together, before any output is made.
        simulation.run(&mut Trace::default())?;
        simulation.ticks = ticks;
        Ok(simulation)
    }

    /// The standard input that this scenario names, with its parameters; `None` where the command
    /// comes from a file.
    ///
    /// # Errors
    /// As [`Scenario::resolve`].
    pub fn standard_input(&self) -> Result<Option<Input>, Error> {
        let mut settings = self
            .set
            .iter()
            .filter_map(|s| Some((s, s.name_in_input()?)));
        if self.input_file.is_some() {
            return match settings.next() {
                Some((setting, _)) => {
                    let name = &setting.name;
                    let problem = format!("`{name}` is set, but an input file has no parameters");
                    Err(self.at(setting, Error::Conflict(problem)))
                }
                None => Ok(None),
            };
        }
        let mut input = input::named(self.input.as_deref().unwrap_or("pulse"))?;
        for (setting, name) in settings {
            let result = input.set(name, setting.value);
            result.map_err(|error| self.at(setting, checks::not_taken(&input, name, error)))?;
        }
        Ok(Some(input))
    }

    /// The error with the place of the setting that it comes from.
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

    /// The command, how many ticks it runs, and what it is called.
    fn command(&self) -> Result<(Command, u64, String), Error> {
        if self.input.is_some() && self.input_file.is_some() {
            let both = "both an input by name and an input file, expected one of them";
            return Err(Error::Conflict(both.into()));
        }
        if let Some(input) = self.standard_input()? {
            let ticks = input.duration_ticks()?;
            return Ok((
                Command::Excitation(input.excitation()?),
                ticks,
                input.name().into(),
            ));
        }
        let path = self.input_file.as_deref().unwrap_or("".as_ref());
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
