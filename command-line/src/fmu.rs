//! `actuator fmu`.

use std::{
    fs::File,
    io::BufWriter,
    path::{Path, PathBuf},
};

use actuator_fmu::archive::{self, Library};
use clap::Args;
use model_core::{actuator::Actuator, presets::PRESETS};

use super::{output, parameters, simulate};
use crate::error::Error;
use host_sim::error::Error as SimulatorError;
use host_sim::{
    scenario::{Scenario, Setting},
    settings::{ModelKind, PlantKind, Settings},
};

/// Writes the actuator as a functional mock-up unit: FMI 2.0 for co-simulation
///
/// Every parameter of the model is a parameter of the unit; --preset and --set change its start
/// value.
#[derive(Debug, Args)]
pub struct Fmu {
    /// The file to write
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// What stands for the actuator
    #[arg(long, default_value = "board", value_parser = parameters::named::<ModelKind>())]
    model: ModelKind,
    /// What the board drives [default: first-order]
    #[arg(long, value_parser = parameters::named::<PlantKind>())]
    plant: Option<PlantKind>,
    /// A reading of the paper [default: `paper` for a black box, else `consistent`]
    #[arg(long, value_name = "NAME", value_parser = parameters::preset_names(PRESETS))]
    preset: Option<String>,
    /// Sets a parameter by name or by symbol, as often as needed; of two values the last counts
    #[arg(long, value_name = "NAME=VALUE", value_parser = parameters::setting)]
    set: Vec<Setting>,
    /// A shared library to put in, for Linux or Windows on x86-64, one of each at most [default: the
    /// one that was built along with this program]
    #[arg(long, value_name = "FILE")]
    library: Vec<PathBuf>,
}

impl Fmu {
    pub(super) fn run(self) -> Result<(), Error> {
        let scenario = Scenario {
            model: Some(self.model),
            plant: self.plant,
            preset: self.preset,
            set: self.set,
            ..Scenario::default()
        };
        let settings = scenario.settings()?;
        // Finds parameters that exclude each other.
        Actuator::try_new(&settings)?;
        let libraries = libraries(&self.library)?;
        simulate::warn(&scenario);
        Ok(write(&self.out, &settings, &libraries)?)
    }
}

fn libraries(paths: &[PathBuf]) -> Result<Vec<Library>, Error> {
    if paths.is_empty() {
        let library = Library::beside_program().map_err(of_library)?;
        return Ok(vec![library]);
    }
    let read = paths
        .iter()
        .map(|path| Library::read(path).map_err(of_library));
    read.collect()
}

fn of_library(error: archive::Error) -> Error {
    match error {
        archive::Error::Read { path, source } => SimulatorError::Read { path, source }.into(),
        archive::Error::NoLibrary { .. } => Error::Conflict(format!("{error}, --library FILE")),
        error => Error::Conflict(error.to_string()),
    }
}

fn write(path: &Path, settings: &Settings, libraries: &[Library]) -> Result<(), Error> {
    let failed = |source| output::write_error(path, source);
    archive::check(libraries).map_err(of_library)?;
    let file = File::create(path).map_err(failed)?;
    archive::write(settings, libraries, BufWriter::new(file)).map_err(failed)
}
