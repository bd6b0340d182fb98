//! Files with the parameters of an actuator: device configuration files (CiA 306-1), and TOML.

use std::collections::BTreeMap;

use canopen_generator::{Access, Row, actuator};
use host_sim::can::names;
use serde_json::{Map, Value};

/// The key of a value in a DCF.
const VALUE: &str = "ParameterValue";

/// The table of a TOML file.
const TABLE: &str = "parameters";

/// The text of a value; `None` for one that no file contains.
fn text(value: &Value) -> Option<String> {
    match value {
        Value::String(text) => Some(text.clone()),
        Value::Number(number) => Some(number.to_string()),
        _ => None,
    }
}

fn row_of_address(address: &str) -> Option<&'static Row> {
    names::find(address).ok()
}

/// Whether a file sets the entry: it is writable and keeps what is written.
fn is_setting(row: &Row) -> bool {
    let is_writable = matches!(row.access, Access::Rw | Access::Rww);
    let is_command = row
        .value
        .as_ref()
        .is_some_and(|value| value.location == canopen_generator::StorageLocation::Command);
    is_writable && !is_command && !matches!(row.index, 0x1003 | 0x1010 | 0x1011)
}

/// A DCF: the electronic data sheet with the value of each entry, for a node.
///
/// # Errors
/// If the dictionary of the firmware cannot be read.
pub fn dcf(values: &Map<String, Value>, node: u8, kbit_s: u16) -> Result<String, String> {
    let files = actuator::documents().map_err(|error| error.to_string())?;
    let eds = files.iter().find(|(path, _)| path.ends_with(".eds"));
    let eds = eds.map_or("", |(_, eds)| eds);
    let mut out = String::new();
    for section in eds.split("\n\n") {
        let name = section
            .strip_prefix('[')
            .and_then(|rest| rest.split_once(']'));
        let value = name
            .and_then(|(name, _)| values.get(&address(name)?))
            .and_then(text);
        let section = match name {
            Some(("FileInfo", _)) => {
                section.replace(".eds", ".dcf") + "\nLastEDS=smart-actuator.eds"
            }
            _ => section.trim_end().to_owned(),
        };
        out += &section;
        if let Some(value) = value {
            out += &format!("\n{VALUE}={value}");
        }
        out += "\n\n";
    }
    // The spelling is that of CiA 306.
    out += &format!(
        "[DeviceComissioning]\nNodeID={node}\nNodeName=actuator-{node}\nBaudrate={kbit_s}\n\
         NetNumber=1\nNetworkName=\nCANopenManager=0\n"
    );
    Ok(out)
}

/// The address of a section of an EDS: `6040` or `607Dsub1`.
fn address(section: &str) -> Option<String> {
    let (index, sub) = match section.split_once("sub") {
        Some((index, sub)) => (index, u8::from_str_radix(sub, 16).ok()?),
        None => (section, 0),
    };
    (index.len() == 4 && u16::from_str_radix(index, 16).is_ok())
        .then(|| format!("{}:{sub}", index.to_ascii_uppercase()))
}

/// A TOML file with the settings by their names.
///
/// # Errors
/// A value that TOML cannot represent.
pub fn toml(values: &Map<String, Value>) -> Result<String, String> {
    let settings = values.iter().filter_map(|(address, value)| {
        let row = row_of_address(address).filter(|row| is_setting(row))?;
        let value = match value {
            Value::Number(number) => match number.as_i64() {
                Some(value) => toml::Value::Integer(value),
                None => toml::Value::Float(number.as_f64()?),
            },
            Value::String(text) => toml::Value::String(text.clone()),
            _ => return None,
        };
        Some((names::name(row), value))
    });
    let table: toml::Table = settings.collect();
    let file = toml::Table::from_iter([(TABLE.to_owned(), toml::Value::Table(table))]);
    toml::to_string(&file).map_err(|error| error.to_string())
}

/// The settings in a DCF or a TOML file, as texts by their addresses.
///
/// # Errors
/// The file is neither, or names an object that the actuator lacks.
pub fn parse(text: &str) -> Result<BTreeMap<String, String>, String> {
    // The first section of a DCF.
    let is_dcf = |line: &str| line.starts_with(VALUE) || line == "[FileInfo]";
    if text.lines().any(|line| is_dcf(line.trim_start())) {
        parse_dcf(text)
    } else {
        parse_toml(text)
    }
}

fn parse_dcf(text: &str) -> Result<BTreeMap<String, String>, String> {
    let (mut section, mut values) = (None, BTreeMap::new());
    for (number, line) in (1..).zip(text.lines()) {
        let line = line.trim();
        if let Some(name) = line
            .strip_prefix('[')
            .and_then(|rest| rest.strip_suffix(']'))
        {
            section = address(name);
        } else if let Some((VALUE, value)) = line.split_once('=').map(|(k, v)| (k.trim(), v.trim()))
        {
            let Some(address) = &section else {
                return Err(format!("line {number}: a value outside of an object"));
            };
            let Some(row) = row_of_address(address) else {
                return Err(format!(
                    "line {number}: the actuator has no object {address}"
                ));
            };
            if is_setting(row) {
                let checked = names::encode(row, value);
                checked.map_err(|error| format!("line {number}: {address}: {error}"))?;
                values.insert(address.clone(), value.to_owned());
            }
        } else if line.starts_with('[') {
            return Err(format!(
                "line {number}: `{line}`, expected a section as `[6040]`"
            ));
        }
    }
    match values.is_empty() {
        true => Err(format!("the DCF has no {VALUE} of a setting")),
        false => Ok(values),
    }
}

fn parse_toml(text: &str) -> Result<BTreeMap<String, String>, String> {
    let neither =
        || format!("the file is neither a DCF with values nor TOML with a table [{TABLE}]");
    let file: toml::Table = text.parse().map_err(|error: toml::de::Error| {
        let before = error.span().and_then(|span| text.get(..span.start));
        let line = 1 + before.unwrap_or_default().matches('\n').count();
        format!("{}: line {line}: {}", neither(), error.message())
    })?;
    let Some(toml::Value::Table(table)) = file.get(TABLE) else {
        return Err(neither());
    };
    let settings = table.iter().map(|(name, value)| {
        let row = names::find(name).map_err(|error| error.to_string())?;
        let value = match value {
            toml::Value::Integer(value) => value.to_string(),
            toml::Value::Float(value) => value.to_string(),
            toml::Value::String(text) => text.clone(),
            other => return Err(format!("{name} is {other}, expected a number or a text")),
        };
        Ok((format!("{:04X}:{}", row.index, row.sub_index()), value))
    });
    settings.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn values() -> Map<String, Value> {
        let values = json!({
            "6064:0": 12, "607D:1": -45_000, "60FB:1": 7.5, "1008:0": "SMART-ACTUATOR", "1800:5": 4,
            "6040:0": 15,
        });
        values.as_object().unwrap().clone()
    }

    fn settings() -> BTreeMap<String, String> {
        let settings = [("1800:5", "4"), ("607D:1", "-45000"), ("60FB:1", "7.5")];
        settings.map(|(a, v)| (a.to_owned(), v.to_owned())).into()
    }

    #[test]
    fn both_formats_read_back_the_settings_and_no_command_or_measurement() {
        let dcf = dcf(&values(), 3, 1000).unwrap();
        assert!(dcf.contains("[6064]\nParameterName=Position actual value"));
        assert!(dcf.contains("\nParameterValue=SMART-ACTUATOR\n"));
        assert!(dcf.contains("NodeID=3\n") && dcf.contains("FileName=smart-actuator.dcf"));
        assert_eq!(parse(&dcf).unwrap(), settings());
        assert_eq!(parse(&toml(&values()).unwrap()).unwrap(), settings());
    }

    #[test]
    fn a_file_that_is_none_is_refused_with_the_place() {
        for (text, expected) in [
            (
                "[9999]\nParameterValue=1\n",
                "line 2: the actuator has no object 9999:0",
            ),
            ("ParameterValue=1\n", "line 1: a value outside of an object"),
            (
                "[parameters]\nstatuswort = 1\n",
                "did you mean `statusword`",
            ),
            ("[other]\n", "neither a DCF"),
            (
                "[FileInfo]\nFileName=actuator.dcf\n[60",
                "line 3: `[60`, expected a section as `[6040]`",
            ),
            ("[FileInfo]\n", "the DCF has no ParameterValue of a setting"),
            (
                "[607D]\n[607Dsub1]\nParameterValue=0xZZ\n",
                "line 3: 607D:1: ",
            ),
            ("[parameters", "neither a DCF with values nor TOML"),
            (
                "[parameters]\n\"607D:1\" = true\n",
                "expected a number or a text",
            ),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
    }
}
