//! Reads JSON: a list of samples, alone, in a member of an object, or one in each line; or an
//! object with a list for each column. Members of members are columns as `header.stamp`.
//!
//! The numbers next to `entries` apply to the whole run. In the recordings of Rhoban's BAM project
//! they are mass and length of the pendulum and the supply; angles are in radians there.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde_json::{Map, Value, value::RawValue};

use super::{ImportError, Quantity, Table, clock, table::Column};

/// Names of the numbers of the whole run in these files, with those of the model parameters.
const CONSTANTS: [(&str, &str); 4] = [
    ("mass", "pendulum_mass_kg"),
    ("length", "pendulum_length_m"),
    ("vin", "supply_v"),
    ("kp", "firmware_gain"),
];

/// Members of a time stamp of ROS, s and ns.
const STAMPS: [[&str; 2]; 3] = [["sec", "nanosec"], ["secs", "nsecs"], ["sec", "nsec"]];

/// Reads the file.
pub fn read(bytes: Vec<u8>, mut table: Table) -> Result<Table, ImportError> {
    let bytes = String::from_utf8(bytes);
    let text = bytes.map_err(|_| table.problem(1, "it is not UTF-8, as JSON is"))?;
    let text = text.trim_start_matches('\u{feff}');
    let values = serde_json::Deserializer::from_str(text).into_iter::<&RawValue>();
    let values: Vec<&RawValue> = values.collect::<Result<_, _>>().map_err(|error| {
        let problem = format!("column {}: {error}", error.column());
        table.problem(error.line() as u64, problem)
    })?;
    let unexpected = |error: serde_json::Error| error.to_string();
    let samples: Result<Vec<&RawValue>, String> = match &values[..] {
        [one] if one.get().starts_with('{') => match samples_of(&mut table, one) {
            Ok(Some(samples)) => Ok(samples),
            Ok(None) => return columns(table, one),
            Err(error) => Err(unexpected(error)),
        },
        [one] => serde_json::from_str(one.get()).map_err(unexpected),
        lines => Ok(lines.to_vec()),
    };
    let samples = samples.map_err(|problem| table.problem(1, problem))?;
    let mut lines = LineNumbers::new(text);
    for (index, sample) in samples.into_iter().enumerate() {
        let line = lines.of(sample.get());
        let mut row = Vec::new();
        match serde_json::from_str(sample.get()) {
            Ok(Value::Object(members)) => {
                flatten(&members, "", &mut row);
                // The joints of a robot, as ROS publishes them.
                let is_list = |name| members.get(name).is_some_and(Value::is_array);
                table.radians |= is_list("name") && is_list("position");
            }
            Ok(Value::Array(values)) => {
                let name =
                    |(index, value): (usize, &Value)| ((index + 1).to_string(), number(value));
                row.extend(values.iter().enumerate().map(name));
            }
            _ => {
                let problem = format!("sample {}, expected an object or a list", index + 1);
                return Err(table.problem(line, problem));
            }
        }
        table.push(line, row);
    }
    table.radians |= table.names.iter().any(|name| name.starts_with("effort"));
    Ok(table)
}

/// The samples in a member of an object; `None` without such a member.
fn samples_of<'a>(
    table: &mut Table,
    object: &'a RawValue,
) -> Result<Option<Vec<&'a RawValue>>, serde_json::Error> {
    let members: BTreeMap<String, &RawValue> = serde_json::from_str(object.get())?;
    let has_samples = |value: &&RawValue| {
        let inside = value.get().strip_prefix('[');
        inside.is_some_and(|inside| inside.trim_start().starts_with('{'))
    };
    let mut lists = members.iter().filter(|(_, value)| has_samples(value));
    let mut recordings = lists
        .clone()
        .filter(|(_, value)| has_command_and_angle(value));
    let samples = match (members.get("entries"), recordings.next(), recordings.next()) {
        (None, Some((a, _)), Some((b, _))) => {
            let problem = format!("`{a}` and `{b}` are lists of samples, expected one recording");
            return Err(serde::de::Error::custom(problem));
        }
        (entries, first, _) => entries.or(first.or(lists.next()).map(|(_, value)| value)),
    };
    for (theirs, ours) in CONSTANTS {
        let value = members
            .get(theirs)
            .and_then(|value| value.get().parse().ok());
        table
            .constants
            .extend(value.map(|value| (ours.to_owned(), value)));
    }
    table.radians = members.contains_key("trajectory") && members.contains_key("motor");
    samples
        .map(|samples| serde_json::from_str(samples.get()))
        .transpose()
}

/// Whether the first sample of a list has a command and an angle.
fn has_command_and_angle(list: &RawValue) -> bool {
    let mut items = serde_json::Deserializer::from_str(list.get().trim_start_matches('['));
    let Ok(first) = Map::<String, Value>::deserialize(&mut items) else {
        return false;
    };
    let mut row = Vec::new();
    flatten(&first, "", &mut row);
    let names: Vec<String> = row.into_iter().map(|(name, _)| name).collect();
    [Quantity::Command, Quantity::Angle]
        .iter()
        .all(|quantity| !matches!(quantity.find(&names), Ok(None)))
}

/// The columns of an object with a list or, as pandas writes it, an object for each.
fn columns(table: Table, object: &RawValue) -> Result<Table, ImportError> {
    let members: Map<String, Value> = serde_json::from_str(object.get()).unwrap_or_default();
    // Of pandas with `orient="split"`.
    if let (Some(Value::Array(names)), Some(Value::Array(rows))) =
        (members.get("columns"), members.get("data"))
    {
        let names = names
            .iter()
            .map(|name| name.as_str().unwrap_or_default().to_owned());
        let names: Vec<String> = names.collect();
        let mut table = table;
        for (row, values) in (1..).zip(rows) {
            let values = values.as_array().into_iter().flatten().map(number);
            table.push(row, names.iter().cloned().zip(values));
        }
        return Ok(table);
    }
    let mut columns = Vec::new();
    lists(&members, "", &mut columns);
    if columns.is_empty() {
        let problem = "no samples, expected a list of objects or an object of lists";
        return Err(table.problem(1, problem));
    }
    table.with(Ok(vec![(String::new(), columns)]))
}

/// The lists of numbers in an object and in its members, by name.
fn lists(members: &Map<String, Value>, prefix: &str, columns: &mut Vec<Column>) {
    for (name, value) in members {
        let name = format!("{prefix}{name}");
        match value {
            Value::Array(values) => columns.push((name, values.iter().map(number).collect())),
            Value::Object(rows) if rows.values().all(|row| !row.is_array() && !row.is_object()) => {
                let index = |(key, value): (&String, &Value)| (key.parse().ok(), number(value));
                let mut rows: Vec<(Option<u64>, f64)> = rows.iter().map(index).collect();
                rows.sort_by_key(|(index, _)| *index);
                columns.push((name, rows.into_iter().map(|(_, value)| value).collect()));
            }
            Value::Object(members) => lists(members, &format!("{name}."), columns),
            _ => {}
        }
    }
}

/// The numbers in an object and in its members, by name.
pub fn flatten(members: &Map<String, Value>, prefix: &str, row: &mut Vec<(String, f64)>) {
    flatten_named(members, prefix, None, row);
}

/// The same in a message that names the items of its lists, the joints of a robot.
fn flatten_named(
    members: &Map<String, Value>,
    prefix: &str,
    joints: Option<&Vec<Value>>,
    row: &mut Vec<(String, f64)>,
) {
    let own = members.get("name").or_else(|| members.get("joint_names"));
    let joints = own.and_then(Value::as_array).or(joints);
    for (name, value) in members {
        let name = format!("{prefix}{name}");
        match value {
            Value::Object(members) => match stamp_s(members) {
                Some(time_s) => row.push((name, time_s)),
                None => flatten_named(members, &format!("{name}."), joints, row),
            },
            Value::Array(values) => {
                for (index, value) in values.iter().enumerate() {
                    let joint = joints.and_then(|joints| joints.get(index)?.as_str());
                    let name = match joint {
                        Some(joint) => format!("{name}.{joint}"),
                        None => format!("{name}[{index}]"),
                    };
                    row.push((name, number(value)));
                }
            }
            value => row.push((name, number(value))),
        }
    }
}

/// The seconds of a time stamp of ROS.
fn stamp_s(members: &Map<String, Value>) -> Option<f64> {
    let of = |names: &[&str; 2]| {
        let [seconds, rest] = names.map(|name| members.get(name)?.as_f64());
        Some(seconds? + 1e-9 * rest?)
    };
    STAMPS.iter().find_map(of)
}

/// The number of a value, NaN for null, and infinite for what is no number: that is an error only
/// where it is used.
fn number(value: &Value) -> f64 {
    match value {
        Value::Number(number) => number.as_f64().unwrap_or(f64::INFINITY),
        Value::Bool(flag) => f64::from(u8::from(*flag)),
        Value::Null => f64::NAN,
        Value::String(text) => {
            let number = text.parse().ok().filter(|number: &f64| number.is_finite());
            number
                .or_else(|| clock::seconds(text))
                .unwrap_or(f64::INFINITY)
        }
        Value::Array(_) | Value::Object(_) => f64::INFINITY,
    }
}

/// Counts lines up to increasing positions.
struct LineNumbers<'a> {
    text: &'a str,
    place: usize,
    line: u64,
}

impl<'a> LineNumbers<'a> {
    fn new(text: &'a str) -> Self {
        Self {
            text,
            place: 0,
            line: 1,
        }
    }

    /// The line number of a part of the text.
    fn of(&mut self, part: &str) -> u64 {
        let place = (part.as_ptr() as usize).saturating_sub(self.text.as_ptr() as usize);
        let passed = self.text.as_bytes().get(self.place..place).unwrap_or(&[]);
        self.line += passed.iter().filter(|byte| **byte == b'\n').count() as u64;
        self.place = self.place.max(place);
        self.line
    }
}
