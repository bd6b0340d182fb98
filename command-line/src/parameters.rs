//! Options that name, set and list parameters.

use std::path::Path;

use clap::{
    Args,
    builder::{PossibleValue, PossibleValuesParser, TypedValueParser},
};
use model_core::{named::Named, presets::Preset};

use super::output;
use crate::error::Error;
use host_sim::{
    scenario::{Scenario, Setting},
    settings::Value,
};

#[derive(Debug, Args)]
pub struct ParameterOptions {
    /// Sets a parameter by name or symbol; repeatable, the last value applies
    #[arg(long, value_name = "NAME=VALUE", value_parser = setting)]
    pub set: Vec<Setting>,
    /// Prints every parameter with value, unit, range and source, and exits
    #[arg(long = "list-parameters")]
    pub list: bool,
}

/// The value of `--set`.
pub fn setting(text: &str) -> Result<Setting, String> {
    let (name, value) = text.split_once('=').ok_or("expected NAME=VALUE")?;
    let number = value.trim().parse();
    let number = number.map_err(|_| format!("`{value}` is not a number"))?;
    Ok(Setting::new(name.trim(), number))
}

/// A parameter file as `identify --parameters` writes it.
pub fn read(path: &Path) -> Result<Scenario, Error> {
    let file = Scenario::read(path)?;
    if !file.set.is_empty() {
        return Ok(file);
    }
    Err(Error::Conflict(format!(
        "{} sets no parameter, expected a section [set] as `identify --parameters` writes it",
        path.display()
    )))
}

/// The values of an enumeration by name, with their summaries.
pub fn named<T: Named>() -> impl TypedValueParser<Value = T> {
    let values = T::ALL
        .iter()
        .map(|value| PossibleValue::new(value.name()).help(value.summary().trim_end_matches('.')));
    let unknown = "the parser accepts known names only";
    PossibleValuesParser::new(values).map(move |name| T::named(&name).expect(unknown))
}

/// The names of presets, with their models and summaries.
pub fn preset_names(presets: impl IntoIterator<Item = &'static Preset>) -> PossibleValuesParser {
    PossibleValuesParser::new(presets.into_iter().map(|preset| {
        let models = preset.models.join(", ");
        PossibleValue::new(preset.name).help(format!("{models}: {}", preset.summary))
    }))
}

/// Writes the parameters as text or as JSON.
pub fn print(parameters: &[(String, Value)], to: &output::Json) -> Result<(), Error> {
    let text = || output::print(&list(parameters, output::width()));
    to.write(|| json(parameters), text)
}

/// A paragraph for each parameter, in lines of at most `width` columns.
fn list(parameters: &[(String, Value)], width: usize) -> String {
    let mut text = String::new();
    for (name, Value { parameter, value }) in parameters {
        let p = parameter;
        let symbol = match p.symbol {
            "" => String::new(),
            symbol => format!(" ({symbol})"),
        };
        let range = format!("from {} to {}, default {}", p.min, p.max, p.default);
        text += &format!("{name}{symbol} = {value} {}\n", p.unit);
        for line in [range.as_str(), p.meaning, p.source] {
            text += &output::wrapped(line, "    ", width);
        }
    }
    text
}

fn json(parameters: &[(String, Value)]) -> String {
    // JSON has no infinity: an unbounded limit is null.
    let rows = parameters.iter().map(|(name, Value { parameter, value })| {
        let p = parameter;
        serde_json::json!({
            "name": name, "symbol": p.symbol, "value": value, "unit": p.unit,
            "default": p.default, "min": p.min, "max": p.max,
            "meaning": p.meaning, "source": p.source,
        })
    });
    format!("{:#}\n", serde_json::Value::from_iter(rows))
}
