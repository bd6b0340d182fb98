//! The catalogue: models, presets, inputs and their parameters, as JSON.

use model_core::actuator::{ModelKind, PlantKind, Settings};
use model_core::excitation::catalogue::Input;
use model_core::named::Named;
use model_core::parameter::Parameter;
use model_core::presets::Preset;
use serde_json::{Map, Value, json};

use crate::run::COLUMNS;
use crate::scenario::{LONGEST_S, presets};

/// The models with their plants, parameters and presets, the inputs with their parameters, and the
/// columns of a trace. An infinite limit is `null`.
///
/// ```
/// let catalogue = actuator_web::catalogue::catalogue();
/// assert_eq!(catalogue.matches(r#""name":"position_gain""#).count(), 3);
/// ```
pub fn catalogue() -> String {
    let boards = PlantKind::ALL
        .iter()
        .map(|plant| Settings::new(ModelKind::Board, *plant));
    let others = ModelKind::ALL
        .iter()
        .filter(|model| **model != ModelKind::Board);
    let others = others.map(|model| Settings::new(*model, PlantKind::FirstOrder));
    let inputs = Input::NAMES.iter().filter_map(|name| Input::named(name));
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "longest_s": LONGEST_S,
        "columns": COLUMNS,
        "choices": boards.chain(others).map(choice).collect::<Vec<_>>(),
        "inputs": inputs.map(input).collect::<Vec<_>>(),
    })
    .to_string()
}

fn choice(settings: Settings) -> Value {
    let is_board = settings.model == ModelKind::Board;
    let parameters = settings.values().map(|value| parameter(value.parameter));
    json!({
        "model": settings.model.name(),
        "plant": is_board.then(|| settings.plant.name()),
        "summary": settings.model.summary(),
        "plant_summary": settings.plant.summary(),
        "parameters": parameters.collect::<Vec<_>>(),
        "presets": presets(&settings).map(preset).collect::<Vec<_>>(),
    })
}

fn input(input: Input) -> Value {
    json!({
        "name": input.name(),
        "summary": input.summary(),
        "parameters": input.table().iter().map(parameter).collect::<Vec<_>>(),
    })
}

fn parameter(p: &Parameter) -> Value {
    json!({
        "name": p.name,
        "symbol": p.symbol,
        "unit": p.unit,
        "default": p.default,
        "min": p.min,
        "max": p.max,
        "source": p.source,
        "meaning": p.meaning,
    })
}

fn preset(preset: &Preset) -> Value {
    let values = preset.values.iter();
    let values: Map<_, _> = values
        .map(|(name, v)| ((*name).into(), (*v).into()))
        .collect();
    json!({
        "name": preset.name,
        "summary": preset.summary,
        "warning": preset.warning,
        "values": values,
    })
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
            let plant = choice["plant"].as_str().unwrap_or("first-order");
            assert!(!list(choice, "presets").is_empty());
            for preset in list(choice, "presets") {
                let preset = preset["name"].as_str().unwrap();
                let text = format!("model={model}&plant={plant}&preset={preset}");
                assert!(Scenario::parse(&text).is_ok(), "{text}");
            }
            for parameter in list(choice, "parameters") {
                let name = parameter["name"].as_str().unwrap();
                let value = parameter["default"].as_f64().unwrap_or(f64::INFINITY);
                let text = format!("model={model}&plant={plant}&{name}={value}");
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
