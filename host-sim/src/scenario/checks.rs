//! What each entry of a scenario takes, wherever it was said.

use model_core::{excitation::catalogue::Input, parameter::ParameterError, presets};

use super::INPUT_PREFIX;
use crate::error::Error;

/// The longest run, s: four months.
const LONGEST_S: f64 = 1e7;

pub fn duration(duration_s: f64) -> Result<f64, Error> {
    // Written so that NaN fails.
    if duration_s > 0.0 && duration_s <= LONGEST_S {
        return Ok(duration_s);
    }
    Err(Error::Option {
        option: "duration",
        value: duration_s.to_string(),
        expected: "more than 0 and at most 10,000,000 s",
    })
}

pub fn every(every: u64) -> Result<u64, Error> {
    if every > 0 {
        return Ok(every);
    }
    Err(Error::Option {
        option: "every",
        value: every.to_string(),
        expected: "at least 1 tick",
    })
}

pub fn preset(name: String) -> Result<String, Error> {
    if presets::preset(&name).is_some() {
        return Ok(name);
    }
    let known: Vec<_> = presets::PRESETS.iter().map(|preset| preset.name).collect();
    let expected = known.join(", ");
    Err(Error::unknown("preset", &name, known, expected))
}

/// Why an input did not take a value for the parameter called `name`.
pub fn not_taken(input: &Input, name: &str, error: ParameterError) -> Error {
    if error != ParameterError::Unknown {
        // The error begins with the name.
        return Error::Conflict(format!("parameter {INPUT_PREFIX}{error}"));
    }
    let known = input.table().iter().map(|parameter| parameter.name);
    let expected = known
        .clone()
        .map(|name| format!("{INPUT_PREFIX}{name}"))
        .collect::<Vec<_>>()
        .join(", ");
    Error::unknown("input parameter", name, known, expected)
}
