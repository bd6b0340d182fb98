//! `actuator mujoco`.

use std::path::PathBuf;

use clap::Args;
use model_core::{actuator::Actuator, presets::PRESETS};

use super::{output, parameters, simulate};
use crate::error::Error;
use host_sim::{
    file, mjcf,
    scenario::{Scenario, Setting},
    settings::{ModelKind, PlantKind, Pwm},
};

/// Writes the actuator for MuJoCo: a file of MJCF to include, with the engine plugin
///
/// The plugin is built from bindings/mujoco. Without --out the text is printed.
#[derive(Debug, Args)]
pub struct Mujoco {
    /// Model and parameters written by `identify --parameters`; options override them
    #[arg(long = "parameters", value_name = "FILE")]
    parameter_file: Option<PathBuf>,
    /// Model of the actuator [default: board]
    #[arg(long, value_parser = parameters::named::<ModelKind>())]
    model: Option<ModelKind>,
    /// Plant behind the board [default: bench, on which loads act]
    #[arg(long, value_parser = parameters::named::<PlantKind>())]
    plant: Option<PlantKind>,
    /// Interpretation of the paper [default: `paper` for a black box, else `consistent`]
    #[arg(long, value_name = "NAME", value_parser = parameters::preset_names(PRESETS))]
    preset: Option<String>,
    /// Sets a parameter by name or symbol; repeatable, the last value applies
    #[arg(long, value_name = "NAME=VALUE", value_parser = parameters::setting)]
    set: Vec<Setting>,
    /// Seed of the random numbers [default: 0]
    #[arg(long)]
    seed: Option<u64>,
    /// How the bridge is switched [default: average]
    #[arg(long, value_parser = parameters::named::<Pwm>())]
    pwm: Option<Pwm>,
    /// Name of the actuator and of the instance of the plugin
    #[arg(long, default_value = "servo", value_parser = identifier)]
    name: String,
    /// Joint that it turns, a hinge
    #[arg(long, default_value = "joint", value_parser = identifier)]
    joint: String,
    /// File to write
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// A name that needs no escape in XML.
fn identifier(text: &str) -> Result<String, String> {
    let is_plain = |c: char| c.is_alphanumeric() || "_-./".contains(c);
    if !text.is_empty() && text.chars().all(is_plain) {
        return Ok(text.to_owned());
    }
    Err("expected letters, digits, `_`, `-`, `.` and `/`".into())
}

impl Mujoco {
    pub(super) fn run(self) -> Result<(), Error> {
        let fitted = match &self.parameter_file {
            Some(path) => parameters::read(path)?,
            None => Scenario::default(),
        };
        let mut scenario = fitted.overridden_by(Scenario {
            model: self.model,
            plant: self.plant,
            preset: self.preset,
            seed: self.seed,
            pwm: self.pwm,
            ..Scenario::default()
        });
        let model = *scenario.model.get_or_insert(ModelKind::Board);
        if model == ModelKind::Board {
            scenario.plant.get_or_insert(PlantKind::Drivetrain);
        }
        let mut settings = scenario.settings()?;
        // An actuator has no input of its own: only parameters of the model are accepted.
        for Setting { name, value, .. } in &self.set {
            model_core::scenario::set(&mut settings, name, *value)?;
        }
        // Finds parameters that exclude each other.
        Actuator::try_new(&settings)?;
        simulate::warn(&scenario);
        let text = mjcf::servo(&settings, &self.name, &self.joint);
        match &self.out {
            None => output::print(&text),
            Some(path) => {
                file::check(&[("--out", path)], &self.parameter_file)?;
                Ok(file::write(path, text)?)
            }
        }
    }
}
