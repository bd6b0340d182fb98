//! Writes a fitted model as a file for `actuator simulate --parameters`: a TOML scenario with model
//! and parameters.
//!
//! A motor becomes the drivetrain of the board: with the board's own loops where it was fitted
//! from its duty, and with its fitted position loop where it was fitted from its command.

pub mod bam;
mod motor;

use std::fmt::Write as _;

use model_core::{
    actuator::{Actuator, ModelKind, PlantKind, Settings},
    named::Named,
    parameter::ParameterError,
};
use motor::DrivetrainParameters;

use super::fit::{Estimate, Fit};
use super::models::oscillator_gains;

/// Why the simulator cannot simulate a fit.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NotSimulated {
    /// It has no model that corresponds to the fitted one.
    #[error("{model} cannot be simulated alone, expected one of {}", ModelKind::NAMES.join(", "))]
    Model {
        /// The fitted model.
        model: &'static str,
    },
    /// It refuses a value.
    #[error("the fitted {name} of {value} cannot be simulated: {error}")]
    Parameter {
        /// The parameter of the simulator.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The reason.
        error: Box<ParameterError>,
    },
}

/// The text of the file.
///
/// # Errors
/// [`NotSimulated`].
pub fn text(fit: &Fit) -> Result<String, NotSimulated> {
    let drivetrain = DrivetrainParameters::of(fit);
    let kind = simulated(fit.model).ok_or(NotSimulated::Model { model: fit.model })?;
    let plant = match &drivetrain {
        Some(_) => PlantKind::Drivetrain,
        None => PlantKind::FirstOrder,
    };
    let mut settings = Settings::new(kind, plant);
    let known: Vec<&str> = settings.values().map(|v| v.parameter.name).collect();
    let mut text = format!(
        "# {} fitted by actuator {}: fit {:.2} %, noise {:.4} deg.\nmodel = \"{}\"\n",
        fit.model,
        env!("CARGO_PKG_VERSION"),
        fit.fit_percent,
        fit.noise_deg,
        kind.name(),
    );
    if let Some(drivetrain) = &drivetrain {
        let _ = writeln!(text, "plant = \"{}\"", plant.name());
        for remark in drivetrain.remarks() {
            let _ = writeln!(text, "# {remark}");
        }
    }
    let shared = fit.estimates.iter().filter(|e| e.experiment.is_none());
    let simulated = shared.filter(|e| known.contains(&e.name));
    let undetermined =
        simulated.filter(|e| e.is_undetermined() || !(e.fixed || fit.has_converged()));
    let undetermined: Vec<&str> = undetermined.map(|e| e.name).collect();
    if !undetermined.is_empty() {
        let _ = writeln!(text, "undetermined = {undetermined:?}");
    }
    text += "\n[set]\n";
    let mut values = drivetrain.map_or_else(|| values(fit), |drivetrain| drivetrain.values());
    values.retain(|(name, value, _)| known.contains(name) && value.is_finite());
    for (name, value, estimate) in resolvable(&mut settings, values)? {
        // The shortest text that reads back as the same number.
        let _ = write!(text, "{name} = {value:?}");
        let _ = match estimate {
            Some(e) if e.standard_error.is_finite() => writeln!(
                text,
                " # {}, standard error {:.3e}",
                e.unit,
                e.standard_error.max(e.standard_error_coloured)
            ),
            Some(e) if e.is_undetermined() => writeln!(text, " # {}, not identifiable", e.unit),
            _ => writeln!(text),
        };
    }
    Ok(text)
}

/// The values, all of which the simulator takes. An inertia that its steps do not resolve is raised
/// to the least that they do: the motor is then faster than a tick, which no recording shows.
fn resolvable<'a>(
    settings: &mut Settings,
    mut values: Vec<Set<'a>>,
) -> Result<Vec<Set<'a>>, NotSimulated> {
    let refused = |name, value, error| NotSimulated::Parameter {
        name,
        value,
        error: Box::new(error),
    };
    for (name, value, _) in &values {
        let set = settings.set(name, *value);
        set.map_err(|error| refused(name, *value, error))?;
    }
    let Err(error) = Actuator::try_new(settings) else {
        return Ok(values);
    };
    let ParameterError::OutOfRange { parameter, value } = error else {
        return Err(refused("parameters", f64::NAN, error));
    };
    let inertia = values.iter_mut().find(|(name, ..)| *name == INERTIA);
    let Some(inertia) = inertia.filter(|_| parameter.name == INERTIA) else {
        return Err(refused(parameter.name, value, error));
    };
    // Above the bound in the digits that are written.
    inertia.1 = parameter.min * (1.0 + 1e-9);
    settings
        .set(INERTIA, inertia.1)
        .map_err(|error| refused(INERTIA, value, error))?;
    match Actuator::try_new(settings) {
        Ok(_) => Ok(values),
        Err(error) => Err(refused(INERTIA, value, error)),
    }
}

/// The inertia of the motor, the range of which depends on other parameters.
const INERTIA: &str = "motor_inertia_kg_m2";

/// The name of the simulator's model.
fn simulated_as(model: &str) -> &str {
    match model {
        "black-box-2-oscillator" => "black-box-2",
        model => model,
    }
}

/// The simulator's model of a fitted one; `None` where it has no such model.
pub fn simulated(model: &str) -> Option<ModelKind> {
    match motor::form(model) {
        Some(_) => Some(ModelKind::Board),
        None => ModelKind::named(simulated_as(model)),
    }
}

/// The settings of such a file, by the names of the model that it was written for.
pub fn named_for(model: &str, mut settings: Vec<(String, f64)>) -> Vec<(String, f64)> {
    let value = |name: &str| settings.iter().find(|s| s.0 == name).map(|s| s.1);
    let gains = value(POSITION_GAIN).zip(value(RATE_GAIN));
    if let Some((position, rate)) = gains.filter(|_| simulated_as(model) != model) {
        settings.retain(|(name, _)| name != POSITION_GAIN && name != RATE_GAIN);
        let w = position.sqrt();
        settings.push(("natural_frequency_rad_s".into(), w));
        settings.push(("damping".into(), rate / (2.0 * w)));
    }
    settings
}

/// The gains of black box 2, by which the simulator describes the oscillator as well.
const POSITION_GAIN: &str = "position_gain_per_s2";
const RATE_GAIN: &str = "rate_gain_per_s";

/// A parameter of the simulator with its value and its estimate; `None` where it is computed from
/// several estimates.
type Set<'a> = (&'static str, f64, Option<&'a Estimate>);

/// The parameters of the actuator by the simulator's names.
fn values(fit: &Fit) -> Vec<Set<'_>> {
    let shared = fit.estimates.iter().filter(|e| e.experiment.is_none());
    let mut values: Vec<_> = shared.map(|e| (e.name, e.value, Some(e))).collect();
    // The simulator describes the oscillator by its gains.
    let oscillator = fit
        .value("natural_frequency_rad_s")
        .zip(fit.value("damping"));
    if let Some((w, damping)) = oscillator {
        let (position_gain, rate_gain) = oscillator_gains(w, damping);
        values.push((POSITION_GAIN, position_gain, None));
        values.push((RATE_GAIN, rate_gain, None));
    }
    values
}
