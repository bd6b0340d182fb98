//! `actuator simulate`.

mod sinks;

use std::path::PathBuf;

use clap::{
    Args,
    builder::{PossibleValue, PossibleValuesParser},
};
use model_core::{
    excitation::catalogue::Input,
    presets::{self, PRESETS},
};

use super::parameters::{self, ParameterOptions};
use crate::error::Error;
use crate::output::Json;
use host_sim::{
    scenario::{INPUT_PREFIX, Scenario},
    settings::{ModelKind, PlantKind, Pwm, Value},
};
use sinks::{Outputs, Sinks};

/// Runs a model on an input
///
/// Without --csv a summary is printed. --set also sets parameters of the input, as
/// `input.NAME=VALUE`; --list-parameters prints those of the selected model and input.
#[derive(Debug, Args)]
pub struct Simulate {
    /// Model to simulate
    #[arg(value_parser = parameters::named::<ModelKind>())]
    model: Option<ModelKind>,
    /// Scenario file in TOML; options override it
    #[arg(long, value_name = "FILE")]
    scenario: Option<PathBuf>,
    /// Model and parameters written by `identify --parameters`; --set overrides them
    #[arg(long = "parameters", value_name = "FILE")]
    parameter_file: Option<PathBuf>,
    /// Interpretation of the paper [default: `paper` for a black box, else `consistent`]
    #[arg(long, value_name = "NAME", value_parser = parameters::preset_names(PRESETS))]
    preset: Option<String>,
    /// Plant behind the board [default: first-order]
    #[arg(long, value_parser = parameters::named::<PlantKind>())]
    plant: Option<PlantKind>,
    /// Standard input by name [default: pulse]
    #[arg(long, value_name = "NAME", value_parser = input_names(), conflicts_with = "input_file")]
    input: Option<String>,
    /// Command from a text file with columns of times and commands, as time_s and command_deg, held
    /// between rows: a trace, a recording or a designed input
    #[arg(long, value_name = "FILE")]
    input_file: Option<PathBuf>,
    /// Torque on the load of the bench, from a text file with the columns time_s and load_torque_nm
    #[arg(long, value_name = "FILE")]
    load_file: Option<PathBuf>,
    #[command(flatten)]
    parameters: ParameterOptions,
    /// Prints the list of --list-parameters as JSON
    #[arg(long, requires = "list")]
    json: bool,
    /// How long to run, s [default: as long as the input]
    #[arg(long, value_name = "SECONDS")]
    duration: Option<f64>,
    /// Ticks of 50 us between two rows [default: 20]
    #[arg(long, value_name = "N")]
    every: Option<u64>,
    /// Seed of the random numbers [default: 0]
    #[arg(long)]
    seed: Option<u64>,
    /// How the bridge is switched [default: average]
    #[arg(long, value_parser = parameters::named::<Pwm>())]
    pwm: Option<Pwm>,
    /// Writes the trace as CSV, regardless of the name; `-` is standard output
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Writes the trace as .csv, as .mat for MATLAB and Octave, or as .parquet (builds with that
    /// feature); repeatable
    #[arg(long, value_name = "FILE")]
    out: Vec<PathBuf>,
    /// Plots the trace as .svg or interactive .html
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
}

pub(super) fn input_names() -> PossibleValuesParser {
    let inputs = Input::NAMES.iter().filter_map(|name| Input::named(name));
    PossibleValuesParser::new(inputs.map(|input| {
        PossibleValue::new(input.name())
            .help(input.summary().trim_end_matches('.'))
            .aliases(input.alias())
    }))
}

impl Simulate {
    pub(super) fn run(self) -> Result<(), Error> {
        let scenario = self.scenario()?;
        if self.parameters.list {
            let parameters = parameters(&scenario)?;
            return parameters::print(&parameters, &Json::flag(self.json));
        }
        let simulation = scenario.resolve()?;
        warn(&scenario);
        let outputs = Outputs {
            csv: self.csv,
            files: self.out,
            plot: self.plot,
        };
        let files = [&scenario.input_file, &scenario.load_file];
        let files = files
            .into_iter()
            .chain([&self.scenario, &self.parameter_file]);
        let read: Vec<_> = files.flatten().collect();
        let mut sinks = Sinks::create(&scenario, &simulation, outputs, &read)?;
        simulation.run(&mut sinks)?;
        sinks.finish()?;
        Ok(())
    }

    fn scenario(&self) -> Result<Scenario, Error> {
        let base = match &self.scenario {
            Some(path) => Scenario::read(path)?,
            None => Scenario::default(),
        };
        let mut fitted = match &self.parameter_file {
            Some(path) => parameters::read(path)?,
            None => Scenario::default(),
        };
        if base.path.is_some() {
            // An error names the first of two files: line numbers of the second would mislead.
            fitted
                .set
                .iter_mut()
                .for_each(|setting| setting.line = None);
        }
        Ok(base.overridden_by(fitted).overridden_by(Scenario {
            model: self.model,
            plant: self.plant,
            preset: self.preset.clone(),
            input: self.input.clone(),
            input_file: self.input_file.clone(),
            load_file: self.load_file.clone(),
            duration_s: self.duration,
            every: self.every,
            seed: self.seed,
            pwm: self.pwm,
            set: self.parameters.set.clone(),
            ..Scenario::default()
        }))
    }
}

/// Prints the warning of a preset to standard error.
pub(super) fn warn(scenario: &Scenario) {
    let preset = scenario.preset.as_deref().and_then(presets::preset);
    if let Some(warning) = preset.and_then(|preset| preset.warning) {
        note!("warning: {warning}");
    }
}

/// The parameters of the model and of its input.
fn parameters(scenario: &Scenario) -> Result<Vec<(String, Value)>, Error> {
    let described = scenario.described()?;
    let values = described.values().filter_map(|(is_of_input, value)| {
        let name = value.parameter.name;
        match (is_of_input, &scenario.input_file) {
            (false, _) => Some((name.into(), value)),
            (true, None) => Some((format!("{INPUT_PREFIX}{name}"), value)),
            (true, Some(_)) => None,
        }
    });
    Ok(values.collect())
}
