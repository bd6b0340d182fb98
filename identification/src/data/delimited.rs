//! Reads text with one sample in each line.

use std::path::Path;

use super::{Progress, Table};
use crate::{
    data::ImportError,
    data::lines::{Delimiter, Lines, TextLine},
};

/// Lines between two reports of progress.
const LINES_PER_REPORT: usize = 1 << 14;
/// Representations of a missing number.
const MISSING: [&str; 7] = ["", "nan", "na", "n/a", "null", "none", "-"];

/// Reads the file. The first line names the columns, unless all its fields are numbers; the second
/// may name their units.
pub fn read(
    path: &Path,
    delimiter: Option<Delimiter>,
    progress: &mut Progress<'_>,
) -> Result<Table, ImportError> {
    let size = std::fs::metadata(path).map_or(0, |file| file.len());
    let mut lines = Lines::delimited(path, delimiter)?;
    let Some(header) = lines.next_line()? else {
        return Err(lines.problem("the file is empty, expected a header and samples".into()));
    };
    let mut table = Table {
        path: path.into(),
        header_line: header.number(),
        columns: vec![Vec::new(); header.fields.len()],
        ..Table::default()
    };
    if header.fields.iter().all(|field| number(field).is_some()) {
        table.names = (1..=header.fields.len()).map(|n| n.to_string()).collect();
        push(&mut table, &header)?;
    } else {
        table.names = header.fields.to_vec();
    }
    while let Some(line) = lines.next_line()? {
        if table.is_empty() && table.units.is_empty() && are_units(line.fields) {
            table.units = line.fields.to_vec();
            continue;
        }
        push(&mut table, &line)?;
        if table.len().is_multiple_of(LINES_PER_REPORT) {
            progress(lines.read, size);
        }
    }
    progress(size, size);
    Ok(table)
}

/// Whether a line contains no number.
fn are_units(fields: &[String]) -> bool {
    let is_word = |field: &String| number(field).is_none();
    fields.iter().all(is_word) && fields.iter().any(|field| !field.is_empty())
}

fn push(table: &mut Table, line: &TextLine<'_>) -> Result<(), ImportError> {
    let (found, expected) = (line.fields.len(), table.columns.len());
    if found != expected {
        let problem = format!("the fields are {found}, expected {expected} as in the header");
        return Err(line.problem(problem));
    }
    for (index, field) in line.fields.iter().enumerate() {
        // A column of text is an error only where it is used.
        let value = number(field).unwrap_or(f64::INFINITY);
        table.columns[index].push(value);
    }
    table.lines.push(line.number());
    Ok(())
}

/// The number in a field, NaN where it is missing; `None` for any other text. A decimal comma is
/// accepted.
fn number(field: &str) -> Option<f64> {
    let parsed = field.parse().ok().or_else(|| {
        let with_point = field.contains(',').then(|| field.replacen(',', ".", 1));
        with_point.and_then(|field| field.parse().ok())
    });
    match parsed {
        // Infinite values are not measurements.
        Some(value) => Some(value).filter(|value: &f64| !value.is_infinite()),
        None => {
            let lower = field.to_ascii_lowercase();
            MISSING.contains(&lower.as_str()).then_some(f64::NAN)
        }
    }
}
