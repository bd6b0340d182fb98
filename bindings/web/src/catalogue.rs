//! The catalogue: models, presets, inputs and their parameters, as JSON.

use std::collections::BTreeMap;

use model_core::actuator::{ModelKind, Settings};
use model_core::excitation::catalogue::Input;
use model_core::named::Named;
use model_core::parameter::Parameter;
use model_core::presets::Preset;
use model_core::scenario::{self, presets};
use serde::Serialize;

use crate::run::COLUMNS;
use crate::scenario::LONGEST_S;

#[derive(Serialize)]
struct Catalogue {
    version: &'static str,
    longest_s: f64,
    columns: [&'static str; COLUMNS.len()],
    choices: Vec<Choice>,
    inputs: Vec<InputEntry>,
}

#[derive(Serialize)]
struct Choice {
    model: &'static str,
    plant: Option<&'static str>,
    summary: &'static str,
    plant_summary: &'static str,
    parameters: Vec<&'static Parameter>,
    presets: Vec<PresetEntry>,
}

#[derive(Serialize)]
struct PresetEntry {
    name: &'static str,
    summary: &'static str,
    warning: Option<&'static str>,
    values: BTreeMap<&'static str, f64>,
}

#[derive(Serialize)]
struct InputEntry {
    name: &'static str,
    summary: &'static str,
    parameters: &'static [Parameter],
}

/// The models with their plants, parameters and presets, the inputs with their parameters, and the
/// columns of a trace. An infinite limit is `null`.
///
/// ```
/// let catalogue = actuator_web::catalogue::catalogue();
/// assert_eq!(catalogue.matches(r#""name":"position_gain""#).count(), 3);
/// ```
pub fn catalogue() -> String {
    let (boards, others): (Vec<_>, Vec<_>) =
        scenario::choices().partition(|settings| settings.model == ModelKind::Board);
    let inputs = Input::NAMES.iter().filter_map(|name| Input::named(name));
    crate::json(&Catalogue {
        version: env!("CARGO_PKG_VERSION"),
        longest_s: LONGEST_S,
        columns: COLUMNS,
        choices: boards.into_iter().chain(others).map(Choice::of).collect(),
        inputs: inputs.map(InputEntry::of).collect(),
    })
}

impl Choice {
    fn of(settings: Settings) -> Self {
        let is_board = settings.model == ModelKind::Board;
        Self {
            model: settings.model.name(),
            plant: is_board.then(|| settings.plant.name()),
            summary: settings.model.summary(),
            plant_summary: settings.plant.summary(),
            parameters: settings.values().map(|value| value.parameter).collect(),
            presets: presets(&settings).map(PresetEntry::of).collect(),
        }
    }
}

impl PresetEntry {
    fn of(preset: &'static Preset) -> Self {
        Self {
            name: preset.name,
            summary: preset.summary,
            warning: preset.warning,
            values: preset.values.iter().copied().collect(),
        }
    }
}

impl InputEntry {
    fn of(input: Input) -> Self {
        Self {
            name: input.name(),
            summary: input.summary(),
            parameters: input.table(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Scenario;
    use serde_json::Value;

    fn read() -> Value {
        serde_json::from_str(&catalogue()).unwrap()
    }

    fn list<'a>(value: &'a Value, key: &str) -> &'a [Value] {
        value[key].as_array().unwrap()
    }

    #[test]
    fn every_choice_of_the_catalogue_runs() {
        for choice in list(&read(), "choices") {
            let model = choice["model"].as_str().unwrap();
            let plant = choice["plant"].as_str();
            let plant = plant.map_or(String::new(), |plant| format!("&plant={plant}"));
            assert!(!list(choice, "presets").is_empty());
            for preset in list(choice, "presets") {
                let preset = preset["name"].as_str().unwrap();
                let text = format!("model={model}{plant}&preset={preset}");
                assert!(Scenario::parse(&text).is_ok(), "{text}");
            }
            for parameter in list(choice, "parameters") {
                let name = parameter["name"].as_str().unwrap();
                let value = parameter["default"].as_f64().unwrap_or(f64::INFINITY);
                let text = format!("model={model}{plant}&{name}={value}");
                assert!(Scenario::parse(&text).is_ok(), "{text}");
            }
        }
    }

    #[test]
    fn there_are_five_choices_and_every_input() {
        assert_eq!(list(&read(), "choices").len(), 5);
        assert_eq!(list(&read(), "inputs").len(), Input::NAMES.len());
        let warned = catalogue().matches("contradicts the paper").count();
        assert_eq!(warned, 2, "the grey box and the board as printed");
    }
}
