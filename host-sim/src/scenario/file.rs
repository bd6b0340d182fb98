//! A scenario from a TOML file. Each error names its line.

use std::{collections::BTreeMap, path::Path, str::Utf8Error};

use identification::{bounded_file, parameter_file::bam};
use model_core::named::Named;
use model_core::presets;
use model_core::scenario::{self, NameKind, ScenarioError};
use serde::{Deserialize, Deserializer, de::Error as _};
use toml::Spanned;

use super::{Scenario, Setting};
use crate::error::Error;
use crate::settings::{ModelKind, PlantKind, Pwm};

/// The most bytes of a file: a hundred times those of all parameters.
const MOST_BYTES: u64 = 1 << 20;

/// What a file has to be.
const EXPECTED: &str = "expected TOML, or a servo of BAM in JSON";

/// Kinds of files that are no text in UTF-8, by their first bytes.
const BINARY: [(&[u8], &str); 5] = [
    (b"\x1f\x8b", "a gzip file"),
    (b"PK\x03\x04", "a zip archive or a workbook"),
    (b"PAR1", "a Parquet file"),
    (b"\xff\xfe", "text in UTF-16"),
    (b"\xfe\xff", "text in UTF-16"),
];

/// The problem of a file that is not in UTF-8.
fn binary(bytes: &[u8], error: Utf8Error) -> String {
    let kind = BINARY.iter().find(|(head, _)| bytes.starts_with(head));
    if let Some((_, kind)) = kind {
        return format!("{kind}, {EXPECTED}");
    }
    let line = 1 + bytes[..error.valid_up_to()]
        .iter()
        .filter(|byte| **byte == b'\n')
        .count();
    format!("line {line} is no text in UTF-8, {EXPECTED}")
}

/// Whether a text has a section that each DCF and EDS begins with.
fn is_of_canopen(text: &str) -> bool {
    let is_one = |line: &str| line.starts_with("[FileInfo") || line.starts_with("[DeviceInfo");
    text.lines().any(is_one)
}

impl Scenario {
    /// Reads a TOML file, or a servo of BAM in JSON.
    ///
    /// # Errors
    /// [`Error::Read`], and [`Error::ScenarioFile`] with line, key and the expected value.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let bytes = bounded_file::read(path, MOST_BYTES).map_err(|source| Error::Read {
            path: path.into(),
            source,
        })?;
        let not_toml = |problem: String| Error::ScenarioFile {
            path: path.into(),
            problem,
        };
        let text = str::from_utf8(&bytes).map_err(|error| not_toml(binary(&bytes, error)))?;
        if is_of_canopen(text) {
            return Err(not_toml(format!("a DCF or EDS of CANopen, {EXPECTED}")));
        }
        let of_bam = text.trim_start().starts_with('{').then(|| bam::text(text));
        let of_bam = of_bam
            .transpose()
            .map_err(|error| not_toml(error.to_string()))?;
        let text = of_bam.as_deref().unwrap_or(text);
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

/// A value that `check` accepts and converts.
fn checked<'de, T: Deserialize<'de>, U, D: Deserializer<'de>>(
    deserializer: D,
    check: impl FnOnce(T) -> Result<U, Error>,
) -> Result<Option<U>, D::Error> {
    let value = T::deserialize(deserializer)?;
    check(value).map(Some).map_err(D::Error::custom)
}

fn named<'de, T: Named, D: Deserializer<'de>>(
    kind: NameKind,
    deserializer: D,
) -> Result<Option<T>, D::Error> {
    checked(deserializer, |name: String| {
        Ok(scenario::named(kind, &name)?)
    })
}

pub fn model<'de, D: Deserializer<'de>>(d: D) -> Result<Option<ModelKind>, D::Error> {
    named(NameKind::Model, d)
}

pub fn plant<'de, D: Deserializer<'de>>(d: D) -> Result<Option<PlantKind>, D::Error> {
    named(NameKind::Plant, d)
}

pub fn pwm<'de, D: Deserializer<'de>>(d: D) -> Result<Option<Pwm>, D::Error> {
    named(NameKind::Pwm, d)
}

pub fn preset<'de, D: Deserializer<'de>>(d: D) -> Result<Option<String>, D::Error> {
    checked(d, |name: String| {
        let kind = NameKind::Preset(None);
        match presets::preset(&name) {
            Some(_) => Ok(name),
            None => Err(ScenarioError::Unknown { kind, name: &name }.into()),
        }
    })
}

pub fn input<'de, D: Deserializer<'de>>(d: D) -> Result<Option<String>, D::Error> {
    checked(d, |name: String| {
        scenario::input(&name)?;
        Ok(name)
    })
}

pub fn duration<'de, D: Deserializer<'de>>(d: D) -> Result<Option<f64>, D::Error> {
    checked(d, |duration_s| {
        scenario::check_duration(duration_s)?;
        Ok(duration_s)
    })
}

pub fn every<'de, D: Deserializer<'de>>(d: D) -> Result<Option<u64>, D::Error> {
    checked(d, |every| {
        scenario::check_every(every)?;
        Ok(every)
    })
}

/// The settings in the order of the file, each with its offset in bytes in place of its line: the
/// text is not known here.
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
