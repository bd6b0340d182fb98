//! A scenario from a TOML file, each of whose errors names its line.

use std::{collections::BTreeMap, fs, path::Path};

use model_core::named::Named;
use serde::{Deserialize, Deserializer, de::Error as _};
use toml::Spanned;

use super::{Scenario, Setting, checks};
use crate::{error::Error, input};

impl Scenario {
    /// Reads a TOML file.
    ///
    /// # Errors
    /// [`Error::Read`], and [`Error::ScenarioFile`] with line, key and what was expected.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let bytes = fs::read(path).map_err(|source| Error::Read {
            path: path.into(),
            source,
        })?;
        let not_toml = |problem: String| Error::ScenarioFile {
            path: path.into(),
            problem,
        };
        let text = str::from_utf8(&bytes)
            .map_err(|error| not_toml(format!("{error}, expected UTF-8 text")))?;
        let mut scenario: Self = toml::from_str(text)
            .map_err(|error| not_toml(error.to_string().trim_end().to_owned()))?;
        for line in scenario.set.iter_mut().filter_map(|s| s.line.as_mut()) {
            *line = text[..*line].lines().count().max(1);
        }
        let files = [&mut scenario.input_file, &mut scenario.load_file];
        for file in files.into_iter().flatten() {
            *file = path.with_file_name("").join(&file);
        }
        scenario.path = Some(path.into());
        Ok(scenario)
    }
}

fn checked<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
    deserializer: D,
    check: fn(T) -> Result<T, Error>,
) -> Result<Option<T>, D::Error> {
    let value = T::deserialize(deserializer)?;
    check(value).map(Some).map_err(D::Error::custom)
}

pub fn named<'de, T: Named, D: Deserializer<'de>>(deserializer: D) -> Result<Option<T>, D::Error> {
    let name = String::deserialize(deserializer)?;
    let names = T::NAMES.iter().copied();
    let unknown = || D::Error::custom(Error::unknown("name", &name, names, T::NAMES.join(", ")));
    T::named(&name).ok_or_else(unknown).map(Some)
}

pub fn preset<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<String>, D::Error> {
    checked(deserializer, checks::preset)
}

pub fn input<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<String>, D::Error> {
    checked(deserializer, |name: String| {
        input::named(&name).map(|_| name)
    })
}

pub fn duration<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    checked(deserializer, checks::duration)
}

pub fn every<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<u64>, D::Error> {
    checked(deserializer, checks::every)
}

/// The settings in the order of the file, each with its byte in place of its line: here nobody
/// knows the text.
pub fn set<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<Setting>, D::Error> {
    let values = BTreeMap::<String, Spanned<f64>>::deserialize(deserializer)?;
    let settings = values.into_iter().map(|(name, value)| Setting {
        name,
        line: Some(value.span().start),
        value: value.into_inner(),
    });
    let mut settings: Vec<_> = settings.collect();
    settings.sort_by_key(|setting| setting.line);
    Ok(settings)
}
