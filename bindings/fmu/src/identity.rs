//! The settings of a GUID.
//!
//! Every FMU contains its settings in `resources/settings.txt`. The GUID is a hash over them and so
//! shows whether library, model description and settings belong together. An FMU with default
//! settings is identified by its GUID alone and needs no resources.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use model_core::actuator::{ModelKind, Settings};
use model_core::scenario::{self, Request};

use crate::description::guid;

/// The name of the file with the settings, within the resources.
pub const SETTINGS_FILE: &str = "settings.txt";

/// The settings of the FMU with this GUID; `resources` is the URI of its resources.
///
/// # Errors
/// The problem.
///
/// ```
/// use actuator_fmu::{description::guid, identity};
/// use model_core::scenario;
///
/// let settings = scenario::choices().next().unwrap();
/// assert_eq!(identity::find(&guid(&settings), None), Ok(settings));
/// assert!(identity::find("{0}", None).is_err());
/// ```
pub fn find(expected: &str, resources: Option<&str>) -> Result<Settings, String> {
    if let Some(settings) = scenario::choices().find(|settings| guid(settings) == expected) {
        return Ok(settings);
    }
    let unknown = |why: &str| {
        format!("guid is `{expected}`, which does not belong to a model of this library{why}")
    };
    let Some(resources) = resources else {
        return Err(unknown(", and there is no resource location"));
    };
    let path = path_of_uri(resources).join(SETTINGS_FILE);
    let text = read(&path).map_err(|why| unknown(&format!(", and {why}")))?;
    let settings = from_text(&text).map_err(|why| format!("{}: {why}", path.display()))?;
    if guid(&settings) == expected {
        Ok(settings)
    } else {
        Err(unknown(&format!(
            " with the settings of {}",
            path.display()
        )))
    }
}

/// Reads a file of settings, which is a short text.
fn read(path: &Path) -> Result<String, String> {
    /// Ten times the size of the largest.
    const LONGEST: u64 = 1 << 16;
    let failed = |error| format!("cannot read {}: {error}", path.display());
    let metadata = fs::metadata(path).map_err(failed)?;
    if !metadata.is_file() || metadata.len() > LONGEST {
        return Err(format!("{} is not a file of settings", path.display()));
    }
    fs::read_to_string(path).map_err(failed)
}

/// The settings as lines of a name, a space and a value.
pub fn to_text(settings: &Settings) -> String {
    let mut text = format!(
        "model {}\nplant {}\npwm {}\nseed {}\n",
        settings.model, settings.plant, settings.pwm, settings.seed
    );
    for value in settings.values() {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{} {}", value.parameter.name, value.value);
    }
    text
}

/// The settings that [`to_text`] wrote.
///
/// # Errors
/// The line that is invalid.
pub fn from_text(text: &str) -> Result<Settings, String> {
    let mut lines = text.lines().filter_map(|line| line.split_once(' '));
    let mut request = Request::default();
    for option in ["model", "plant", "pwm", "seed"] {
        let value = match lines.next() {
            Some((found, value)) if found == option => value,
            _ => return Err(format!("expected a line `{option} ...`")),
        };
        let parsed = request.parse(option, value);
        parsed.map_err(|error| error.to_string())?;
    }
    // The file has this line for every model.
    request.plant = request
        .plant
        .filter(|_| request.model == Some(ModelKind::Board));
    let mut settings = request.settings().map_err(|error| error.to_string())?;
    for (name, value) in lines {
        let number = value.parse();
        let number = number.map_err(|_| format!("{name} is `{value}`, expected a number"))?;
        let set = scenario::set(&mut settings, name, number);
        set.map_err(|error| error.to_string())?;
    }
    Ok(settings)
}

/// The path of a `file:` URI; any other text is a path.
fn path_of_uri(uri: &str) -> PathBuf {
    let Some(rest) = uri.strip_prefix("file:") else {
        return uri.into();
    };
    // `file:/path`, `file:///path` and `file://localhost/path` all occur.
    let path = match rest.strip_prefix("//") {
        Some(with_host) => with_host.find('/').map_or("", |at| &with_host[at..]),
        None => rest,
    };
    let path = percent_decoded(path);
    if cfg!(windows) {
        // `/C:/path`.
        return path.trim_start_matches('/').into();
    }
    path.into()
}

fn percent_decoded(text: &str) -> String {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let [first, after @ ..] = rest {
        let hex = after.get(..2).and_then(|two| str::from_utf8(two).ok());
        let byte = hex.and_then(|two| u8::from_str_radix(two, 16).ok());
        if let (b'%', Some(byte)) = (first, byte) {
            bytes.push(byte);
            rest = &after[2..];
        } else {
            bytes.push(*first);
            rest = after;
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use model_core::actuator::PlantKind;
    use model_core::presets::PRESETS;
    use proptest::prelude::*;

    fn changed() -> Settings {
        let mut settings = Settings::new(ModelKind::GreyBox, PlantKind::FirstOrder);
        let preset = PRESETS.iter().find(|p| p.name == "as-printed").unwrap();
        settings.apply(preset).unwrap();
        settings
    }

    #[test]
    fn settings_come_back_from_their_text() {
        for settings in scenario::choices().chain([changed()]) {
            assert_eq!(from_text(&to_text(&settings)), Ok(settings));
        }
    }

    #[test]
    fn changed_settings_are_found_by_their_file_and_only_with_their_guid() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("a b");
        fs::create_dir(&place).unwrap();
        fs::write(place.join(SETTINGS_FILE), to_text(&changed())).unwrap();
        let uri = format!("file://{}/a%20b", folder.path().display());
        assert_eq!(find(&guid(&changed()), Some(&uri)), Ok(changed()));
        assert_eq!(
            find(&guid(&changed()), place.to_str()),
            Ok(changed()),
            "a plain path"
        );
        let mut other = changed();
        other.set("position_gain", 1.0).unwrap();
        assert!(find(&guid(&other), Some(&uri)).is_err());
        assert!(find(&guid(&changed()), Some("file:///nowhere")).is_err());
    }

    #[test]
    fn uris_of_every_shape_name_the_same_path() {
        for uri in [
            "file:/x/y%25",
            "file:///x/y%25",
            "file://localhost/x/y%25",
            "/x/y%",
        ] {
            assert_eq!(path_of_uri(uri), Path::new("/x/y%"));
        }
    }

    proptest! {
        #[test]
        fn arbitrary_text_is_not_accepted_as_settings(text in "\\PC*", uri in "file:\\PC*") {
            prop_assert!(from_text(&text).is_err());
            let _ = path_of_uri(&uri);
        }
    }
}
