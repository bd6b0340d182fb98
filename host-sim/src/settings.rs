//! The parameters of a model by name, with errors that say what was expected.

pub mod group;

pub use model_core::{
    actuator::{ModelKind, PlantKind, Settings},
    parameter::Value,
    plant::Pwm,
};

use model_core::{
    named::Named,
    parameter::ParameterError,
    presets::{self, Preset},
};

use crate::error::Error;

/// Sets a parameter by name or by symbol.
///
/// # Errors
/// [`Error::UnknownName`] where the model has none of this name, [`Error::Parameter`] where it
/// cannot take the value.
pub fn set(settings: &mut Settings, name: &str, value: f64) -> Result<(), Error> {
    match settings.set(name, value) {
        Err(ParameterError::Unknown) => {
            let command = match settings.model {
                ModelKind::Board => format!("simulate board --plant {}", settings.plant),
                model => format!("simulate {model}"),
            };
            Err(group::unknown(
                settings.values().map(|v| v.parameter),
                name,
                &command,
            ))
        }
        result => Ok(result?),
    }
}

/// Applies a preset of the model.
///
/// # Errors
/// [`Error::UnknownName`] where the model has no such preset, and [`Error::Conflict`] where the
/// preset is for a plant that was not chosen.
pub fn apply(settings: &mut Settings, preset: &str) -> Result<&'static Preset, Error> {
    let Some(found) = settings.model.presets().find(|known| known.name == preset) else {
        return Err(no_preset(settings.model, preset));
    };
    let has = |name: &str| {
        settings
            .values()
            .any(|value| value.parameter.is_called(name))
    };
    if let Some((name, _)) = found.values.iter().find(|(name, _)| !has(name)) {
        return Err(Error::Conflict(format!(
            "preset `{preset}` sets {name} of the first-order motor, which --plant bench replaces; \
             expected --plant first-order, or --set for the bench"
        )));
    }
    settings.apply(found)?;
    Ok(found)
}

fn no_preset(model: ModelKind, name: &str) -> Error {
    let names: Vec<_> = model.presets().map(|preset| preset.name).collect();
    let expected = names.join(", ");
    match presets::preset(name) {
        Some(elsewhere) => Error::Conflict(format!(
            "preset `{name}` is for {}, not for {}: {}; expected {expected}",
            elsewhere.models.join(" and "),
            model.name(),
            elsewhere.summary
        )),
        None => Error::unknown("preset", name, names, expected),
    }
}
