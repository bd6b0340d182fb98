//! `actuator export`.

use std::path::PathBuf;

use clap::{
    Args,
    builder::{PossibleValue, PossibleValuesParser},
};
use identification::export::{self, TARGETS, Target};
use model_core::{excitation::catalogue::Input, presets::PRESETS};

use super::{output, parameters, simulate};
use crate::error::Error;
use host_sim::{
    file,
    scenario::{Scenario, Setting},
    settings::{ModelKind, PlantKind},
};

/// Writes a model as the actuator of another simulator
///
/// The law of that actuator is fitted to the response of the model, without a load, on two inputs.
/// The file states the error on another input and what is lost. Without --out it is printed.
#[derive(Debug, Args)]
pub struct Export {
    /// Model and parameters written by `identify --parameters`; options override them
    #[arg(value_name = "FILE")]
    parameter_file: Option<PathBuf>,
    /// What to write
    #[arg(long, value_name = "TARGET", value_parser = targets())]
    to: String,
    /// Model of the actuator [default: board]
    #[arg(long, value_parser = parameters::named::<ModelKind>())]
    model: Option<ModelKind>,
    /// Plant behind the board [default: first-order]
    #[arg(long, value_parser = parameters::named::<PlantKind>())]
    plant: Option<PlantKind>,
    /// Interpretation of the paper [default: `paper` for a black box, else `consistent`]
    #[arg(long, value_name = "NAME", value_parser = parameters::preset_names(PRESETS))]
    preset: Option<String>,
    /// Sets a parameter by name or symbol, or of the input as `input.NAME=VALUE`; repeatable
    #[arg(long, value_name = "NAME=VALUE", value_parser = parameters::setting)]
    set: Vec<Setting>,
    /// First input of the fit by name; a sweep follows, or 3-2-1-1 after a sweep [default: 3-2-1-1]
    #[arg(long, value_name = "NAME", value_parser = simulate::input_names())]
    input: Option<String>,
    /// Period of the simulator, s [default: the usual one]
    #[arg(long, value_name = "SECONDS")]
    step: Option<f64>,
    /// File to write
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

fn targets() -> PossibleValuesParser {
    let value =
        |target: &'static dyn Target| PossibleValue::new(target.name()).help(target.summary());
    PossibleValuesParser::new(TARGETS.map(value))
}

impl Export {
    pub(super) fn run(self) -> Result<(), Error> {
        let fitted = match &self.parameter_file {
            Some(path) => parameters::read(path)?,
            None => Scenario::default(),
        };
        let mut scenario = fitted.overridden_by(Scenario {
            model: self.model,
            plant: self.plant,
            preset: self.preset,
            input: self.input,
            set: self.set,
            ..Scenario::default()
        });
        scenario.model.get_or_insert(ModelKind::Board);
        scenario.input.get_or_insert(export::INPUT.into());
        let described = scenario.described()?;
        simulate::warn(&scenario);
        let input: &Input = &described.input;
        let target = export::named(&self.to).expect("the parser accepts known names only");
        let found = export::export(&described.settings, target, input, self.step);
        let found = found.map_err(|error| Error::Conflict(error.to_string()))?;
        match &self.out {
            None => output::print(&found.text),
            Some(path) => {
                file::check(&[("--out", path)], &self.parameter_file)?;
                file::write(path, found.text)?;
                output::print(&format!(
                    "{}: {:.4} deg rms from the model on {}\n",
                    path.display(),
                    found.error_deg,
                    found.validation
                ))
            }
        }
    }
}
