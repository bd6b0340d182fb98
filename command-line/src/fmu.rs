//! `actuator fmu`.

use std::path::{Path, PathBuf};

use actuator_fmu::archive::{self, Library, Version};
use clap::Args;
use model_core::{actuator::Actuator, presets::PRESETS};

use super::{output, parameters, simulate};
use crate::bounded::{self, MOST_BUILD};
use crate::error::Error;
use host_sim::{
    file::{self, WholeFile},
    scenario::{Scenario, Setting},
    settings::{ModelKind, PlantKind, Settings},
};

/// Writes the actuator as a Functional Mock-up Unit: FMI 2.0 or 3.0 for co-simulation
///
/// Every parameter of the model is a parameter of the unit; --preset and --set change its start
/// value. Of the board the gains are tunable.
#[derive(Debug, Args)]
pub struct Fmu {
    /// File to write
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Version of the standard
    #[arg(long, value_name = "VERSION", default_value = "2", value_parser = version)]
    fmi: Version,
    /// Model of the actuator
    #[arg(long, default_value = "board", value_parser = parameters::named::<ModelKind>())]
    model: ModelKind,
    /// Plant behind the board [default: first-order]
    #[arg(long, value_parser = parameters::named::<PlantKind>())]
    plant: Option<PlantKind>,
    /// Interpretation of the paper [default: `paper` for a black box, else `consistent`]
    #[arg(long, value_name = "NAME", value_parser = parameters::preset_names(PRESETS))]
    preset: Option<String>,
    /// Sets a parameter by name or symbol; repeatable, the last value applies
    #[arg(long, value_name = "NAME=VALUE", value_parser = parameters::setting)]
    set: Vec<Setting>,
    /// Shared library to include, at most one each for Linux and Windows on x86-64 [default: those
    /// inside this program or, without them, the one built along with it]
    #[arg(long, value_name = "FILE")]
    library: Vec<PathBuf>,
}

impl Fmu {
    pub(super) fn run(self) -> Result<(), Error> {
        let scenario = Scenario {
            model: Some(self.model),
            plant: self.plant,
            preset: self.preset,
            ..Scenario::default()
        };
        let mut settings = scenario.settings()?;
        // A unit has no input of its own: only parameters of the model are accepted.
        for Setting { name, value, .. } in &self.set {
            model_core::scenario::set(&mut settings, name, *value)?;
        }
        // Finds parameters that exclude each other.
        Actuator::try_new(&settings)?;
        file::check(&[("--out", &self.out)], &self.library)?;
        let libraries = libraries(&self.library)?;
        simulate::warn(&scenario);
        write(&self.out, &settings, self.fmi, &libraries)
    }
}

/// The libraries inside this program, with the names of their files: those of a release.
const INSIDE: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/fmu_libraries.rs"));

fn libraries(paths: &[PathBuf]) -> Result<Vec<Library>, Error> {
    if paths.is_empty() && !INSIDE.is_empty() {
        let library = |(path, bytes): &(&str, &[u8])| {
            Library::of(Path::new(path), bytes.to_vec()).map_err(of_library)
        };
        return INSIDE.iter().map(library).collect();
    }
    let read = |path: &PathBuf| {
        let bytes = bounded::read(path, MOST_BUILD)?;
        Library::of(path, bytes).map_err(of_library)
    };
    if paths.is_empty() {
        let beside = archive::beside_program().map_err(of_library)?;
        return Ok(vec![read(&beside)?]);
    }
    paths.iter().map(read).collect()
}

fn of_library(error: archive::Error) -> Error {
    match error {
        archive::Error::NoLibrary { .. } => Error::Conflict(format!("{error}, --library FILE")),
        error => Error::Conflict(error.to_string()),
    }
}

fn version(text: &str) -> Result<Version, String> {
    match text {
        "2" | "2.0" => Ok(Version::Fmi2),
        "3" | "3.0" => Ok(Version::Fmi3),
        _ => Err("expected 2 or 3".into()),
    }
}

fn write(
    path: &Path,
    settings: &Settings,
    version: Version,
    libraries: &[Library],
) -> Result<(), Error> {
    let failed = |source| output::write_error(path, source);
    archive::check(libraries).map_err(of_library)?;
    let mut file = WholeFile::create(path).map_err(failed)?;
    archive::write(settings, version, libraries, &mut file).map_err(failed)?;
    file.complete().map_err(failed)
}
