//! Description of a simulated run: the actuator, its input, the duration and the interval of
//! recorded rows.
//!
//! Every front end (command line, scenario file, Python, C, browser, FMU) maps its own syntax to a
//! [`Request`] and to parameter values. Names, defaults, ranges and errors are decided here.
//!
//! ```
//! use model_core::scenario::{Request, Scenario};
//!
//! let mut request = Request::default();
//! for (option, value) in [("model", "board"), ("preset", "as-measured"), ("input", "sine")] {
//!     assert_eq!(request.parse(option, value), Ok(true));
//! }
//! let mut scenario = Scenario::try_new(&request).unwrap();
//! scenario.set("P", 12.0).unwrap();
//! scenario.set("input.amplitude_deg", 5.0).unwrap();
//! assert_eq!(scenario.settings.first_order.motor_gain_up, 2.4);
//! assert_eq!(scenario.every, 20);
//! ```

mod error;

pub use error::{NameKind, ScenarioError};

use crate::actuator::{ModelKind, PlantKind, Settings};
use crate::excitation::catalogue::Input;
use crate::named::Named;
use crate::parameter::{ParameterError, Value};
use crate::plant::Pwm;
use crate::presets::{self, Preset};
use crate::time::{UPDATE_PERIOD_TICKS, ticks};

/// Default number of ticks between two rows: 1 ms.
pub const DEFAULT_EVERY: u64 = UPDATE_PERIOD_TICKS;

/// The default input.
pub const DEFAULT_INPUT: &str = "pulse";

/// The prefix of the name of a parameter of the input.
pub const INPUT_PREFIX: &str = "input.";

/// The longest run, s: four months. Ticks are exact in `f64` until then.
pub const LONGEST_S: f64 = 1e7;

/// The options of a run; an option that is `None` has its default.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Request<'a> {
    /// The model. It has no default.
    pub model: Option<ModelKind>,
    /// The plant of the board; other models have none.
    pub plant: Option<PlantKind>,
    /// The preset by name.
    pub preset: Option<&'a str>,
    /// The input by name.
    pub input: Option<&'a str>,
    /// Duration, s; by default that of the input.
    pub duration_s: Option<f64>,
    /// Ticks between two rows.
    pub every: Option<u64>,
    /// Seed of the random numbers.
    pub seed: Option<u64>,
    /// How the bridge is switched.
    pub pwm: Option<Pwm>,
}

impl<'a> Request<'a> {
    /// The names of the options of [`Request::parse`].
    pub const OPTIONS: [&'static str; 8] = [
        "model",
        "plant",
        "preset",
        "input",
        "duration_s",
        "every",
        "seed",
        "pwm",
    ];

    /// Sets an option from text; `false` if there is no option of this name.
    ///
    /// # Errors
    /// For an invalid value of the option.
    pub fn parse(&mut self, option: &str, value: &'a str) -> Result<bool, ScenarioError<'a>> {
        match option {
            "model" => self.model = Some(named(NameKind::Model, value)?),
            "plant" => self.plant = Some(named(NameKind::Plant, value)?),
            "preset" => self.preset = Some(value),
            "input" => self.input = Some(value),
            "duration_s" => self.duration_s = Some(number("duration_s", value)?),
            "every" => self.every = Some(number("every", value)?),
            "seed" => self.seed = Some(number("seed", value)?),
            "pwm" => self.pwm = Some(named(NameKind::Pwm, value)?),
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// The parameters of the actuator: the defaults, changed by the preset.
    ///
    /// # Errors
    /// For options that are missing, unknown, or exclude each other.
    pub fn settings(&self) -> Result<Settings, ScenarioError<'a>> {
        let model = self.model.ok_or(ScenarioError::NoModel)?;
        if self.plant.is_some() && model != ModelKind::Board {
            return Err(ScenarioError::NoPlant(model));
        }
        // The mean voltage is what every other model has.
        if self.pwm == Some(Pwm::Switched) && model != ModelKind::Board {
            return Err(ScenarioError::NoBridge(model));
        }
        let mut settings = Settings::new(model, self.plant.unwrap_or(PlantKind::FirstOrder));
        settings.pwm = self.pwm.unwrap_or(settings.pwm);
        settings.seed = self.seed.unwrap_or(settings.seed);
        if let Some(name) = self.preset {
            apply_preset(&mut settings, name)?;
        }
        Ok(settings)
    }
}

/// A run, except for a command sequence from a file, which only some front ends support.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scenario {
    /// The actuator.
    pub settings: Settings,
    /// The input with its parameters.
    pub input: Input,
    /// Duration, s; `None` is that of the input.
    pub duration_s: Option<f64>,
    /// Ticks between two rows; not 0.
    pub every: u64,
}

impl Scenario {
    /// The scenario of these options, with the default parameters.
    ///
    /// # Errors
    /// For options that are missing, unknown, out of range, or exclude each other.
    pub fn try_new<'a>(request: &Request<'a>) -> Result<Self, ScenarioError<'a>> {
        let settings = request.settings()?;
        let input = input(request.input.unwrap_or(DEFAULT_INPUT))?;
        if let Some(duration_s) = request.duration_s {
            check_duration(duration_s)?;
        }
        let every = request.every.unwrap_or(DEFAULT_EVERY);
        check_every(every)?;
        Ok(Self {
            settings,
            input,
            duration_s: request.duration_s,
            every,
        })
    }

    /// Sets a parameter of the actuator or, with [`INPUT_PREFIX`], of the input, by name or symbol.
    ///
    /// # Errors
    /// For a parameter that does not exist or a value out of its range; nothing is changed then.
    pub fn set<'n>(&mut self, name: &'n str, value: f64) -> Result<(), ScenarioError<'n>> {
        match name.strip_prefix(INPUT_PREFIX) {
            Some(name) => set_input(&mut self.input, name, value),
            None => set(&mut self.settings, name, value),
        }
    }

    /// Every parameter with its value: those of the actuator, then those of the input, which are
    /// marked by `true` and whose full names begin with [`INPUT_PREFIX`].
    pub fn values(&self) -> impl Iterator<Item = (bool, Value)> + '_ {
        let of_actuator = self.settings.values().map(|value| (false, value));
        let of_input = self.input.table().iter().enumerate();
        let of_input = of_input.map(|(index, parameter)| {
            let value = self.input.get(index).unwrap_or(parameter.default);
            (true, Value { parameter, value })
        });
        of_actuator.chain(of_input)
    }

    /// Duration, ticks.
    ///
    /// # Errors
    /// For parameters of the input that exclude each other.
    pub fn ticks(&self) -> Result<u64, ParameterError> {
        match self.duration_s {
            Some(duration_s) => Ok(run_ticks(duration_s)),
            None => self.input.duration_ticks(),
        }
    }
}

/// The ticks of a run of this duration; at least one.
pub fn run_ticks(duration_s: f64) -> u64 {
    ticks(duration_s).max(1)
}

/// The default settings of every model, and of the board with every plant.
pub fn choices() -> impl Iterator<Item = Settings> {
    let plants = |model| match model {
        ModelKind::Board => PlantKind::ALL,
        _ => &[PlantKind::FirstOrder],
    };
    let models = ModelKind::ALL.iter();
    models.flat_map(move |model| plants(*model).iter().map(|p| Settings::new(*model, *p)))
}

/// The presets that apply to a model and its plant.
pub fn presets(settings: &Settings) -> impl Iterator<Item = &'static Preset> + use<> {
    let settings = *settings;
    let of_model = settings.model.presets();
    of_model.filter(move |preset| settings.clone().apply(preset).is_ok())
}

/// The value of an enumeration with this name.
///
/// # Errors
/// For an unknown name.
pub fn named<T: Named>(kind: NameKind, name: &str) -> Result<T, ScenarioError<'_>> {
    T::named(name).ok_or(ScenarioError::Unknown { kind, name })
}

/// The input of this name with its default parameters.
///
/// # Errors
/// For an unknown input.
pub fn input(name: &str) -> Result<Input, ScenarioError<'_>> {
    let kind = NameKind::Input;
    Input::named(name).ok_or(ScenarioError::Unknown { kind, name })
}

/// Applies the preset of this name.
///
/// # Errors
/// For an unknown preset, and a preset of another model or plant; nothing is changed then.
pub fn apply_preset<'n>(settings: &mut Settings, name: &'n str) -> Result<(), ScenarioError<'n>> {
    let model = settings.model;
    let kind = NameKind::Preset(Some(model));
    let preset = presets::preset(name).ok_or(ScenarioError::Unknown { kind, name })?;
    if !preset.models.contains(&model.name()) {
        return Err(ScenarioError::PresetOfOtherModel { preset, model });
    }
    // The values of a preset are in range: only a missing parameter is possible.
    let result = settings.apply(preset);
    result.map_err(|_| ScenarioError::PresetOfOtherPlant { preset })
}

/// Sets a parameter of the actuator, by name or symbol.
///
/// # Errors
/// For a parameter that does not exist or a value out of its range; nothing is changed then.
pub fn set<'n>(
    settings: &mut Settings,
    name: &'n str,
    value: f64,
) -> Result<(), ScenarioError<'n>> {
    let kind = NameKind::Parameter(settings.model, settings.plant);
    settings.set(name, value).map_err(|error| match error {
        ParameterError::Unknown => ScenarioError::Unknown { kind, name },
        error => ScenarioError::Parameter(error),
    })
}

/// Sets a parameter of the input, by name or symbol without [`INPUT_PREFIX`].
///
/// # Errors
/// For a parameter that does not exist or a value out of its range; nothing is changed then.
pub fn set_input<'n>(
    input: &mut Input,
    name: &'n str,
    value: f64,
) -> Result<(), ScenarioError<'n>> {
    let kind = NameKind::InputParameter(input.table());
    input.set(name, value).map_err(|error| match error {
        ParameterError::Unknown => ScenarioError::Unknown { kind, name },
        error => ScenarioError::InputParameter(error),
    })
}

/// Checks a duration, s.
///
/// # Errors
/// Outside 0 to [`LONGEST_S`].
pub fn check_duration(duration_s: f64) -> Result<(), ScenarioError<'static>> {
    // Written so that NaN fails.
    if duration_s > 0.0 && duration_s <= LONGEST_S {
        return Ok(());
    }
    Err(ScenarioError::Duration(duration_s))
}

/// Checks the ticks between two rows.
///
/// # Errors
/// For 0.
pub fn check_every(every: u64) -> Result<(), ScenarioError<'static>> {
    if every > 0 {
        return Ok(());
    }
    Err(ScenarioError::Every(every))
}

/// The number in the text of an option.
///
/// # Errors
/// For text that is not a number of this type.
pub fn number<'n, T: core::str::FromStr>(
    option: &'static str,
    text: &'n str,
) -> Result<T, ScenarioError<'n>> {
    let expected = match option {
        "duration_s" => "a number",
        _ => "a whole number that is not negative",
    };
    text.parse().map_err(|_| ScenarioError::Value {
        option,
        text,
        expected,
    })
}

#[cfg(test)]
mod tests;
