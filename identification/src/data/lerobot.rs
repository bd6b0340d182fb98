//! Reads LeRobot data sets of versions 2.1 and 3: a folder with `meta/info.json` and tables of
//! Parquet below `data`, whose rows belong to episodes.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::{Path, PathBuf},
};

use serde_json::Value;

use super::{Columns, Import, ImportError, Imported, Note, Progress, Source, Table};

/// The vectors of a data set: command and measured angle of all joints.
const VECTORS: [&str; 2] = ["action", "observation.state"];

/// What LeRobot appends to the name of a joint, for its position.
const SUFFIX: &str = ".pos";

/// The recording of each episode.
pub fn read(
    import: &Import,
    folder: &Path,
    progress: &mut Progress<'_>,
) -> Result<Vec<Imported>, ImportError> {
    let (path, info) = described(folder)?;
    let problem = |problem| invalid(&path, problem);
    let features = VECTORS.map(|vector| joints(&info["features"][vector]["names"]));
    let known = in_both(&features);
    let given = import.columns.joint.as_deref();
    let given = given.map(|joint| joint.trim_end_matches(SUFFIX));
    let is_unknown = given.is_some_and(|given| !known.iter().any(|joint| joint == given));
    if (given.is_none() || is_unknown) && import.columns.selected.is_empty() {
        let expected = match known.is_empty() {
            true => "--column command=action[0] --column angle=observation.state[0]".to_owned(),
            false => format!("--joint with one of {}", known.join(", ")),
        };
        let text = match given.filter(|_| is_unknown) {
            Some(given) => format!("no joint `{given}`, expected {expected}"),
            None => format!("a data set of several joints, expected {expected}"),
        };
        return Err(problem(text));
    }
    let import = &Import {
        columns: Columns {
            joint: given.map(str::to_owned),
            ..import.columns.clone()
        },
        ..import.clone()
    };
    let rate_hz = info["fps"].as_f64().unwrap_or(f64::NAN);
    let mut recordings = Vec::new();
    let mut noted = BTreeSet::new();
    for file in tables(&folder.join("data"))? {
        let mut table = Table::read(&file, None, progress)?;
        name_joints(&mut table, &features);
        for (episode, table) in episodes(&table) {
            let mut imported = import.recording(&table)?;
            imported.recording.name = format!("episode {episode}");
            // What is said of a column holds for all episodes.
            let header_line = table.header_line;
            let is_new = |note: &Note| note.line > header_line || noted.insert(note.text.clone());
            imported.notes.retain(is_new);
            if recordings.is_empty() {
                imported.notes.insert(0, resolution(&path, rate_hz));
            }
            recordings.push(imported);
        }
    }
    Ok(recordings)
}

/// The joints of the data set in a folder.
///
/// # Errors
/// [`ImportError`] of its description.
pub fn joints_of(folder: &Path) -> Result<Vec<String>, ImportError> {
    let (_, info) = described(folder)?;
    let features = VECTORS.map(|vector| joints(&info["features"][vector]["names"]));
    Ok(in_both(&features))
}

/// The joints with command and angle.
fn in_both([commands, angles]: &[Vec<String>; 2]) -> Vec<String> {
    let is_commanded = |joint: &&String| commands.contains(joint);
    angles.iter().filter(is_commanded).cloned().collect()
}

/// The description of a data set, with its path.
fn described(folder: &Path) -> Result<(PathBuf, Value), ImportError> {
    let path = folder.join("meta/info.json");
    if !path.exists() {
        let text = "a folder without this file, expected a LeRobot data set or a file";
        return Err(invalid(&path, text.into()));
    }
    let bytes = Source::open(&path)?.bytes()?;
    let info = serde_json::from_slice(&bytes);
    let info = info.map_err(|error| invalid(&path, error.to_string()))?;
    Ok((path, info))
}

fn invalid(path: &Path, problem: String) -> ImportError {
    ImportError::Content {
        path: path.into(),
        line: 1,
        problem,
    }
}

/// What samples of this rate can determine.
fn resolution(path: &Path, rate_hz: f64) -> Note {
    let interval_ms = 1e3 / rate_hz;
    Note {
        path: path.into(),
        line: 1,
        text: format!(
            "{rate_hz} Hz: the instant of a command within its interval of {interval_ms:.0} ms is \
             not recorded, so a delay is known to about that; time constants below it and \
             frequencies above {:.0} Hz are not determined; gains, rate limits and friction are",
            rate_hz / 3.0
        ),
    }
}

/// The names of the joints in a feature: a list, or a list in an object.
fn joints(names: &Value) -> Vec<String> {
    let list = match names {
        Value::Object(groups) => groups.values().next().unwrap_or(&Value::Null),
        list => list,
    };
    let names = list
        .as_array()
        .into_iter()
        .flatten()
        .filter_map(Value::as_str);
    names
        .map(|name| name.trim_end_matches(SUFFIX).to_owned())
        .collect()
}

/// Gives the items of the vectors the names of their joints.
fn name_joints(table: &mut Table, joints: &[Vec<String>; 2]) {
    for (vector, joints) in VECTORS.iter().zip(joints) {
        for (index, joint) in joints.iter().enumerate() {
            let item = format!("{vector}[{index}]");
            if let Some(name) = table.names.iter_mut().find(|name| **name == item) {
                *name = format!("{vector}.{joint}");
            }
        }
    }
}

/// The rows of each episode.
fn episodes(table: &Table) -> BTreeMap<u64, Table> {
    let numbers = table.names.iter().position(|name| name == "episode_index");
    let mut rows: BTreeMap<u64, Vec<usize>> = BTreeMap::new();
    for row in 0..table.len() {
        let episode = numbers.map_or(0.0, |index| table.columns[index][row]);
        rows.entry(episode as u64).or_default().push(row);
    }
    let of = |rows: &Vec<usize>| Table {
        columns: table
            .columns
            .iter()
            .map(|c| rows.iter().map(|&row| c[row]).collect())
            .collect(),
        lines: rows.iter().map(|&row| table.line(row)).collect(),
        path: table.path.clone(),
        header_line: table.header_line,
        names: table.names.clone(),
        ..Table::default()
    };
    rows.iter()
        .map(|(episode, rows)| (*episode, of(rows)))
        .collect()
}

/// The tables below a folder, by name.
fn tables(folder: &Path) -> Result<Vec<PathBuf>, ImportError> {
    let read = |source| ImportError::Read {
        path: folder.into(),
        source,
    };
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(read)? {
        let path = entry.map_err(read)?.path();
        if path.is_dir() {
            found.extend(tables(&path)?);
        } else if path.extension().is_some_and(|suffix| suffix == "parquet") {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}
