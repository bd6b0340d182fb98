//! Exports a model to the actuators of other simulators.
//!
//! A target has an actuator of its own, with its own update law. The model is simulated on an
//! input with steps and one with a sweep, and the law of the target, in steps of its own period, is
//! fitted to that response by least squares. The file says how far the two are apart on another
//! input, and what is lost.
//!
//! A new target is one file with an implementation of [`Target`] and its line in [`TARGETS`].

mod ardupilot;
mod bam;
mod effects;
mod error;
mod gazebo;
mod isaaclab;
mod joint;
mod jsbsim;
mod law;
mod linear;
mod mujoco;
mod newton;
mod response;
mod search;
#[cfg(test)]
mod tests;

use std::fmt::Write as _;
use std::sync::Arc;

use model_core::actuator::{ModelKind, PlantKind, Settings};
use model_core::control::units::Angle;
use model_core::excitation::{catalogue::Input, variable_step::LEVELS};
use model_core::named::Named;
use model_core::parameter::ParameterError;

pub use effects::Effect;
pub use error::ExportError;

use crate::model::Model;
use error::{LONGEST_S, SHORTEST_S};
use response::{Response, steady, value};

/// All targets.
pub const TARGETS: [&dyn Target; 10] = [
    &mujoco::Position,
    &mujoco::DcMotor,
    &jsbsim::JsbSim,
    &bam::Bam,
    &linear::Matlab,
    &linear::PythonControl,
    &gazebo::Gazebo,
    &isaaclab::IsaacLab,
    &newton::Newton,
    &ardupilot::ArduPilot,
];

/// An actuator of another simulator.
pub trait Target: Sync {
    /// Its name on the command line.
    fn name(&self) -> &'static str;

    /// What is written, in one line.
    fn summary(&self) -> &'static str;

    /// The usual period of the simulator, s.
    fn step_s(&self) -> f64;

    /// The period that the simulator has where this one is requested, s.
    fn nearest_step_s(&self, step_s: f64) -> f64 {
        step_s
    }

    /// What it has of a model.
    fn kept(&self) -> &'static [Effect];

    /// Before and after a line of comment; in JSON, a member for each.
    fn comment(&self) -> (&'static str, &'static str);

    /// Its update law under a setpoint for each step, deg; several forms, simplest first.
    fn laws(&self, about: &About, setpoint_deg: &Arc<[f64]>) -> Vec<Arc<dyn Model>>;

    /// The file but for its comment.
    fn body(&self, fitted: &Fitted) -> String;
}

/// What a target has to know of a model beside its response.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct About {
    /// The period of the simulator, s.
    pub step_s: f64,
    /// Inertia of rotor and horn at the output shaft, kg m^2; an assumption for a model without
    /// torques.
    pub inertia_kg_m2: f64,
    /// Resistance of the winding, ohm, likewise.
    pub resistance_ohm: f64,
    /// Supply, V, likewise.
    pub supply_v: f64,
}

impl About {
    fn of(settings: &Settings, step_s: f64) -> Self {
        let drivetrain = Settings::new(ModelKind::Board, PlantKind::Drivetrain);
        let at = |name| {
            let own = value(settings, name);
            own.or_else(|| value(&drivetrain, name)).unwrap_or(0.0)
        };
        let ratio = at("gear_ratio");
        let beyond = at("output_inertia_kg_m2") + at("load_inertia_kg_m2");
        Self {
            step_s,
            inertia_kg_m2: at("motor_inertia_kg_m2") * ratio * ratio + beyond,
            resistance_ohm: at("winding_resistance_ohm"),
            supply_v: at("supply_v"),
        }
    }
}

/// The parameters of a target.
#[derive(Debug, Clone, PartialEq)]
pub struct Fitted {
    /// What is known of the model.
    pub about: About,
    /// Gain between command and steady angle.
    pub gain: f64,
    values: Vec<(&'static str, f64)>,
}

impl Fitted {
    /// A parameter; NaN where the law has none of this name.
    fn value(&self, name: &str) -> f64 {
        self.found(name).unwrap_or(f64::NAN)
    }

    fn found(&self, name: &str) -> Option<f64> {
        let found = self.values.iter().find(|(known, _)| *known == name);
        found.map(|(_, value)| *value)
    }

    /// The delay in whole steps.
    fn delay_steps(&self) -> u32 {
        self.found("delay_steps").unwrap_or(0.0) as u32
    }
}

/// A model in the terms of a target.
#[derive(Debug, Clone, PartialEq)]
pub struct Export {
    /// The file.
    pub text: String,
    /// The input of the stated error, to which the law is not fitted.
    pub validation: &'static str,
    /// The error against the model on it, deg rms.
    pub error_deg: f64,
    /// The standard deviation of the model's response to it, deg.
    pub spread_deg: f64,
    /// What is lost.
    pub lost: Vec<&'static str>,
}

/// The target of this name.
pub fn named(name: &str) -> Option<&'static dyn Target> {
    TARGETS.into_iter().find(|target| target.name() == name)
}

/// The first input of the fit unless another one is chosen: most servos reach their limits in it.
pub const INPUT: &str = "3-2-1-1";

/// The second input of the fit, of the same amplitude: a sweep over all frequencies of use, or
/// steps where the first one is a sweep.
fn second(first: &Input, amplitude_deg: f64) -> Result<Input, ParameterError> {
    let input = match first {
        Input::Chirp(_) | Input::LogChirp(_) => Input::ThreeTwoOneOne(Default::default()),
        _ => Input::LogChirp(Default::default()),
    };
    with(input, "amplitude_deg", amplitude_deg)
}

/// The input of the stated error, of the same amplitude, to which the law is not fitted: steps of
/// many heights, or of few where the first one has those.
fn validation(first: &Input, amplitude_deg: f64) -> Result<Input, ParameterError> {
    if let Input::VariableStep(_) = first {
        let few = Input::ThreeTwoOneOne(Default::default());
        return with(few, "amplitude_deg", amplitude_deg);
    }
    let greatest_deg = LEVELS.into_iter().fold(Angle::ZERO, |a, b| a.max(b.abs()));
    let scale = amplitude_deg / greatest_deg.to_f64();
    with(Input::VariableStep(Default::default()), "scale", scale)
}

/// An input with another value of one of its parameters.
fn with(mut input: Input, name: &str, value: f64) -> Result<Input, ParameterError> {
    input.set(name, value)?;
    Ok(input)
}

/// Parameters of a load, which the simulator has itself.
const LOAD: [&str; 2] = ["pendulum_mass_kg", "load_torque_nm"];

/// Exports a model, without a load; `step_s` replaces the usual period of the simulator.
///
/// # Errors
/// [`ExportError`].
pub fn export(
    settings: &Settings,
    target: &dyn Target,
    input: &Input,
    step_s: Option<f64>,
) -> Result<Export, ExportError> {
    let step_s = step_s.unwrap_or(target.step_s());
    if !(SHORTEST_S..=LONGEST_S).contains(&step_s) {
        return Err(ExportError::Step(step_s));
    }
    let step_s = target.nearest_step_s(step_s);
    let mut alone = *settings;
    for name in LOAD {
        // A model without a load is as it is.
        let _ = alone.set(name, 0.0);
    }
    let amplitude_deg = Response::of(&alone, &[*input], step_s)?.amplitude_deg;
    let second = second(input, amplitude_deg)?;
    let response = Response::of(&alone, &[*input, second], step_s)?;
    let about = About::of(&alone, step_s);
    let laws = |response: &Response| target.laws(&about, &response.target_deg);
    let unfit = |error| ExportError::Fit {
        target: target.name(),
        error,
    };
    let found = search::best(&laws(&response), &response, step_s).map_err(unfit)?;
    let validation = validation(input, amplitude_deg)?;
    let unseen = Response::of(&alone, &[validation], step_s)?;
    let error_deg = found
        .error_deg(&laws(&unseen), &unseen, step_s)
        .map_err(unfit)?;
    let (fitted_deg, spread_deg) = (found.fitted_deg, unseen.spread_deg());
    if error_deg.is_nan() || error_deg > 0.5 * spread_deg {
        return Err(ExportError::Unlike {
            target: target.name(),
            error_deg,
            spread_deg,
            input: validation.name(),
            fitted_to: [input.name(), second.name()],
        });
    }
    let fitted = Fitted {
        about,
        gain: steady(&alone).0,
        values: found.values,
    };
    let lost = effects::lost(&alone, target.kept());
    let error = format!(
        "Fitted to the model on the inputs {} and {} with an amplitude of {} deg: {fitted_deg:.4} \
         deg rms. Error against it on the input {} with this amplitude, to which it is not fitted, \
         in steps of {} s: {error_deg:.4} deg rms, of a response with a standard deviation of \
         {spread_deg:.2} deg.",
        input.name(),
        second.name(),
        number(amplitude_deg),
        validation.name(),
        number(step_s),
    );
    let lines = comment(&alone, target, error, &lost);
    Ok(Export {
        text: with_comment(target, &lines, &target.body(&fitted)),
        validation: validation.name(),
        error_deg,
        spread_deg,
        lost,
    })
}

/// The lines of the comment.
fn comment(settings: &Settings, target: &dyn Target, error: String, lost: &[&str]) -> Vec<String> {
    let mut lines = vec![
        format!(
            "{}: {}, by actuator {}.",
            target.summary(),
            settings.model.name(),
            env!("CARGO_PKG_VERSION"),
        ),
        error,
    ];
    if !lost.is_empty() {
        lines.push(format!("Lost: {}.", lost.join("; ")));
    }
    if target.kept().contains(&Effect::Torque) && !effects::has_torque(settings) {
        lines.push("The model has no torques: those here are for an assumed inertia.".into());
    }
    let (gain, offset_deg) = steady(settings);
    if (gain, offset_deg) != (1.0, 0.0) {
        let (gain, offset) = (number(gain), number(offset_deg));
        lines.push(format!(
            "Setpoint for a command c: {gain} c + {offset} deg."
        ));
    }
    lines
}

/// The file with its comment.
fn with_comment(target: &dyn Target, lines: &[String], body: &str) -> String {
    let (before, after) = target.comment();
    let mut text = String::new();
    for line in lines {
        let _ = writeln!(text, "{before}{line}{after}");
    }
    body.replace("COMMENT\n", &text)
}

/// The shortest text of a number with six significant digits.
fn number(value: f64) -> String {
    let rounded: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    format!("{rounded}")
}
