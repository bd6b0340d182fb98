//! `actuator fmu`.

use std::{fs::File, io::BufWriter, path::PathBuf};

use actuator_fmu::archive::{self, Library};
use clap::{Args, builder::PossibleValuesParser};
use model_core::actuator::{Actuator, ModelKind, PlantKind, Settings};
use model_core::parameter::ParameterError;
use model_core::presets::preset;

use super::Failure;
use crate::error::Error;

/// Writes the actuator as a functional mock-up unit: FMI 2.0 for co-simulation
///
/// Every parameter of the model is a parameter of the FMU; preset and --set change its start
/// values.
#[derive(Debug, Args)]
pub struct Fmu {
    /// The file to write
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// What stands for the actuator
    #[arg(long, default_value = "board", value_parser = PossibleValuesParser::new(ModelKind::NAMES))]
    model: String,
    /// What the board drives [default: first-order]
    #[arg(long, value_parser = PossibleValuesParser::new(PlantKind::NAMES))]
    plant: Option<String>,
    /// A reading of the paper [default: `paper` for a black box, else `consistent`]
    #[arg(long, value_name = "NAME")]
    preset: Option<String>,
    /// Sets a start value, by name or by symbol
    #[arg(long, value_name = "NAME=VALUE", value_parser = super::simulate::assignment)]
    set: Vec<(String, f64)>,
    /// A shared library to put in, for Linux or Windows on x86-64; one a platform [default: the one
    /// that was built along with this program]
    #[arg(long, value_name = "FILE")]
    library: Vec<PathBuf>,
}

impl Fmu {
    pub(super) fn run(self) -> Result<(), Failure> {
        let settings = self.settings()?;
        let libraries = match self.library.as_slice() {
            [] => vec![Library::beside_program().map_err(failed)?],
            paths => {
                let read = paths.iter().map(|path| Library::read(path));
                read.collect::<Result<_, _>>().map_err(failed)?
            }
        };
        let unwritten = |source| Error::Write {
            path: self.out.clone(),
            source,
        };
        let file = File::create(&self.out).map_err(unwritten)?;
        archive::write(&settings, &libraries, BufWriter::new(file)).map_err(|error| match error {
            archive::Error::Write(error) => unwritten(error.into()),
            error => failed(error),
        })?;
        Ok(())
    }

    fn settings(&self) -> Result<Settings, Error> {
        // The parsers let nothing else through.
        let model = ModelKind::named(&self.model).unwrap_or(ModelKind::Board);
        if self.plant.is_some() && model != ModelKind::Board {
            return Err(Error::Conflict(format!(
                "a plant goes with the model `board`, `{model}` has none"
            )));
        }
        let plant = self.plant.as_deref().and_then(PlantKind::named);
        let mut settings = Settings::new(model, plant.unwrap_or(PlantKind::FirstOrder));
        if let Some(name) = &self.preset {
            apply(&mut settings, name)?;
        }
        for (name, value) in &self.set {
            settings.set(name, *value).map_err(|error| match error {
                ParameterError::Unknown => unknown_parameter(&settings, name),
                error => error.into(),
            })?;
        }
        Actuator::try_new(&settings)?;
        Ok(settings)
    }
}

fn apply(settings: &mut Settings, name: &str) -> Result<(), Error> {
    let known: Vec<_> = settings.model.presets().map(|known| known.name).collect();
    let found = preset(name).filter(|found| known.contains(&found.name));
    let Some(found) = found else {
        let expected = known.join(", ");
        return Err(Error::unknown("preset", name, known, expected));
    };
    if let Some(warning) = found.warning {
        eprintln!("warning: {warning}");
    }
    settings.apply(found).map_err(|error| match error {
        ParameterError::Unknown => Error::Conflict(format!(
            "preset `{name}` sets parameters of the first-order motor, which the bench replaces"
        )),
        error => error.into(),
    })
}

fn unknown_parameter(settings: &Settings, name: &str) -> Error {
    let known = settings.values().map(|value| value.parameter);
    let known = known.flat_map(|parameter| [parameter.name, parameter.symbol]);
    let model = settings.model;
    let expected = format!("one that `actuator simulate {model} --list-parameters` prints");
    Error::unknown("parameter", name, known, expected)
}

fn failed(error: archive::Error) -> Error {
    match error {
        archive::Error::Read { path, source } => Error::Read { path, source },
        error => Error::Conflict(error.to_string()),
    }
}
