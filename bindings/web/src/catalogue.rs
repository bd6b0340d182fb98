//! What there is to choose from, with everything that is known of it, as JSON.

use model_core::actuator::{ModelKind, PlantKind, Settings};
use model_core::excitation::catalogue::Input;
use model_core::named::Named;
use model_core::parameter::Parameter;
use model_core::presets::Preset;

use crate::json::{array, number, object, text};
use crate::run::COLUMNS;
use crate::scenario::{LONGEST_S, presets};

/// The models with their plants, parameters and presets, the inputs with theirs, and the columns of
/// a trace. A limit that is not there is `null`.
///
/// ```
/// let catalogue = actuator_web::catalogue::catalogue();
/// assert_eq!(catalogue.matches(r#""name":"position_gain""#).count(), 3);
/// ```
pub fn catalogue() -> String {
    let board = |plant| Settings::new(ModelKind::Board, plant);
    let first_order = |model| Settings::new(model, PlantKind::FirstOrder);
    let boards = PlantKind::ALL.iter().copied().map(board);
    let others = ModelKind::ALL.iter().copied();
    let others = others.filter(|model| *model != ModelKind::Board);
    let choices = boards.chain(others.map(first_order));
    let inputs = Input::NAMES.iter().filter_map(|name| Input::named(name));
    object([
        ("version", text(env!("CARGO_PKG_VERSION"))),
        ("longest_s", number(LONGEST_S)),
        ("columns", array(COLUMNS.map(text))),
        ("choices", array(choices.map(choice))),
        ("inputs", array(inputs.map(input))),
    ])
}

fn choice(settings: Settings) -> String {
    let plant = match settings.model {
        ModelKind::Board => text(settings.plant.name()),
        _ => "null".into(),
    };
    let parameters = settings.values().map(|value| parameter(value.parameter));
    object([
        ("model", text(settings.model.name())),
        ("plant", plant),
        ("summary", text(settings.model.summary())),
        ("plant_summary", text(settings.plant.summary())),
        ("parameters", array(parameters)),
        ("presets", array(presets(&settings).map(preset))),
    ])
}

fn input(input: Input) -> String {
    object([
        ("name", text(input.name())),
        ("summary", text(input.summary())),
        ("parameters", array(input.table().iter().map(parameter))),
    ])
}

fn parameter(p: &Parameter) -> String {
    object([
        ("name", text(p.name)),
        ("symbol", text(p.symbol)),
        ("unit", text(p.unit)),
        ("default", number(p.default)),
        ("min", number(p.min)),
        ("max", number(p.max)),
        ("source", text(p.source)),
        ("meaning", text(p.meaning)),
    ])
}

fn preset(preset: &Preset) -> String {
    let values = preset.values.iter();
    object([
        ("name", text(preset.name)),
        ("summary", text(preset.summary)),
        ("warning", preset.warning.map_or("null".into(), text)),
        ("values", object(values.map(|(k, v)| (*k, number(*v))))),
    ])
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
    fn everything_that_is_offered_can_be_run() {
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
