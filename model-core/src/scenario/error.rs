//! Errors of a scenario, with the expected values.

use core::fmt;

use super::INPUT_PREFIX;
use crate::actuator::{ModelKind, PlantKind, Settings};
use crate::excitation::catalogue::Input;
use crate::named::Named;
use crate::parameter::{Parameter, ParameterError, Shown};
use crate::plant::Pwm;
use crate::presets::{PRESETS, Preset};

/// Kind of object that a name refers to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NameKind {
    /// A model.
    Model,
    /// A plant of the board.
    Plant,
    /// A switching mode of the bridge.
    Pwm,
    /// A preset of this model, or of any model.
    Preset(Option<ModelKind>),
    /// A standard input.
    Input,
    /// A parameter of this model and plant.
    Parameter(ModelKind, PlantKind),
    /// A parameter of the input with this table.
    InputParameter(&'static [Parameter]),
}

impl NameKind {
    /// The term for it in a message.
    pub const fn label(self) -> &'static str {
        match self {
            Self::Model => "model",
            Self::Plant => "plant",
            Self::Pwm => "pwm",
            Self::Preset(_) => "preset",
            Self::Input => "input",
            Self::Parameter(..) => "parameter",
            Self::InputParameter(_) => "input parameter",
        }
    }

    /// Calls `take` with every known name; for a parameter with its name and its symbol, if any.
    pub fn for_each_name(self, mut take: impl FnMut(&'static str)) {
        let mut parameter = |p: &'static Parameter| {
            [p.name, p.symbol]
                .into_iter()
                .filter(|name| !name.is_empty())
                .for_each(&mut take);
        };
        match self {
            Self::Model => ModelKind::NAMES.iter().copied().for_each(take),
            Self::Plant => PlantKind::NAMES.iter().copied().for_each(take),
            Self::Pwm => Pwm::NAMES.iter().copied().for_each(take),
            Self::Preset(model) => {
                let of_model = |p: &&Preset| model.is_none_or(|m| p.models.contains(&m.name()));
                PRESETS.iter().filter(of_model).for_each(|p| take(p.name));
            }
            Self::Input => Input::NAMES.iter().copied().for_each(take),
            Self::Parameter(model, plant) => {
                let settings = Settings::new(model, plant);
                settings
                    .values()
                    .for_each(|value| parameter(value.parameter));
            }
            Self::InputParameter(table) => table.iter().for_each(parameter),
        }
    }
}

/// The expected names, separated by commas; for the many parameters of a model only a description.
impl fmt::Display for NameKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut separator = "";
        let mut result = Ok(());
        let mut item = |prefix: &str, name: &str| {
            result = result.and_then(|()| write!(f, "{separator}{prefix}{name}"));
            separator = ", ";
        };
        match self {
            Self::Parameter(model, _) => return write!(f, "a parameter of the model {model}"),
            Self::InputParameter(table) => {
                table.iter().for_each(|p| item(INPUT_PREFIX, p.name));
            }
            kind => kind.for_each_name(|name| item("", name)),
        }
        result
    }
}

/// Reason why a scenario is refused.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ScenarioError<'a> {
    /// The model is missing.
    NoModel,
    /// The name is unknown.
    Unknown {
        /// Kind of the named object.
        kind: NameKind,
        /// The name.
        name: &'a str,
    },
    /// A plant is given, but this model has none.
    NoPlant(ModelKind),
    /// Switching of the bridge is asked for, but this model has no bridge.
    NoBridge(ModelKind),
    /// The preset is not one of this model.
    PresetOfOtherModel {
        /// The preset.
        preset: &'static Preset,
        /// The model of the scenario.
        model: ModelKind,
    },
    /// The preset sets parameters of another plant.
    PresetOfOtherPlant {
        /// The preset.
        preset: &'static Preset,
    },
    /// A parameter of the actuator is out of range or excludes another one.
    Parameter(ParameterError),
    /// A parameter of the input is out of range or excludes another one.
    InputParameter(ParameterError),
    /// The duration is out of range, s.
    Duration(f64),
    /// The number of ticks between two rows is out of range.
    Every(u64),
    /// The text is not a value of the option.
    Value {
        /// The option.
        option: &'static str,
        /// The text.
        text: &'a str,
        /// The valid values, in words.
        expected: &'static str,
    },
}

impl From<ParameterError> for ScenarioError<'_> {
    fn from(error: ParameterError) -> Self {
        Self::Parameter(error)
    }
}

impl fmt::Display for ScenarioError<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoModel => write!(f, "no model, expected one of {}", NameKind::Model),
            Self::Unknown { kind, name } => {
                write!(f, "unknown {} `{name}`; expected {kind}", kind.label())
            }
            Self::NoPlant(model) => write!(
                f,
                "`plant` applies to the model `board`, `{model}` has no plant"
            ),
            Self::NoBridge(model) => write!(
                f,
                "`pwm` `switched` applies to the model `board`, `{model}` has no bridge"
            ),
            Self::PresetOfOtherModel { preset, model } => {
                write!(f, "preset `{}` is for ", preset.name)?;
                for (index, of) in preset.models.iter().enumerate() {
                    write!(f, "{}{of}", if index > 0 { " and " } else { "" })?;
                }
                let summary = preset.summary;
                write!(
                    f,
                    ", not for {model}: {summary}; expected {}",
                    NameKind::Preset(Some(*model))
                )
            }
            Self::PresetOfOtherPlant { preset } => write!(
                f,
                "preset `{}` sets parameters of the plant `first-order`; the plant is `bench`",
                preset.name
            ),
            Self::Parameter(error) => write!(f, "parameter {error}"),
            Self::InputParameter(error) => write!(f, "parameter {INPUT_PREFIX}{error}"),
            Self::Duration(value) => write!(
                f,
                "duration is {}, expected more than 0 and at most 10,000,000 s",
                Shown(*value)
            ),
            Self::Every(value) => write!(f, "every is {value}, expected at least 1 tick"),
            Self::Value {
                option,
                text,
                expected,
            } => write!(f, "{option} is `{text}`, expected {expected}"),
        }
    }
}

impl core::error::Error for ScenarioError<'_> {}
