//! Reads text with one sample in each line.
//!
//! The data begin at the first line of numbers. The line of as many fields before it names the
//! columns, or the last comment does; a line between the two may name their units.

use super::{
    ImportError, Progress, Source, Table, clock,
    lines::{Delimiter, Lines},
    names, unit,
};

/// Lines between two reports of progress.
const LINES_PER_REPORT: usize = 1 << 14;
/// Representations of a missing number.
const MISSING: [&str; 11] = [
    "", "nan", "na", "n/a", "#n/a", "null", "none", "-", "--", "?", "1.#qnan",
];
/// The first lines of the two heads of LabVIEW's measurement files, and the last line of each.
const LABVIEW: &str = "LabVIEW Measurement";
const SECOND_HEAD: &str = "Channels";
const END_OF_HEAD: &str = "***End_of_Header***";
/// Lines of text behind the samples that are left out.
const FOOTER: usize = 20;

/// Reads the file.
pub fn read(
    source: Source,
    delimiter: Option<Delimiter>,
    progress: &mut Progress<'_>,
) -> Result<Table, ImportError> {
    let size = source.size;
    let mut lines = Lines::new(source, delimiter);
    let mut table = heading(&mut lines)?;
    let mut cut: Option<ImportError> = None;
    let is_named = table.names.iter().any(|name| number(name).is_none());
    let mut repeated = None;
    while let Some(line) = lines.next_line()? {
        if let Some(error) = cut {
            return Err(error);
        }
        if is_named && (line.fields == table.names || line.fields == table.units) {
            repeated = repeated.or(Some(line.number()));
            continue;
        }
        let is_shorter = line.fields.len() < table.columns.len();
        if let Err(problem) = push(&mut table, line.number(), line.fields) {
            let error = line.problem(problem);
            match is_shorter {
                true => cut = Some(error),
                false => return Err(error),
            }
        }
        if table.len().is_multiple_of(LINES_PER_REPORT) {
            progress(lines.read, size);
        }
    }
    if cut.is_some() {
        let line = table.lines.last().map_or(1, |line| line + 1);
        let text = "the last line is cut off, and left out";
        table.notes.push((line, text.into()));
    }
    if let Some(line) = repeated {
        let text = "the header is repeated, here first, and left out";
        table.notes.push((line, text.into()));
    }
    without_footer(&mut table);
    progress(size, size);
    Ok(table)
}

/// Leaves out the last rows, where they have text and no number.
fn without_footer(table: &mut Table) {
    let has_number = |row: usize| table.columns.iter().any(|column| column[row].is_finite());
    let last = (0..table.len()).rev().find(|row| has_number(*row));
    let rows = last.map_or(0, |last| last + 1);
    let is_text = |row: usize| table.columns.iter().any(|column| column[row].is_infinite());
    if rows == 0 || table.len() - rows > FOOTER || !(rows..table.len()).any(is_text) {
        return;
    }
    let text = "text behind the samples is left out";
    table.notes.push((table.lines[rows], text.into()));
    table.lines.truncate(rows);
    table.columns.iter_mut().for_each(|c| c.truncate(rows));
}

/// A line before the data, or their first.
struct Line {
    number: u64,
    fields: Vec<String>,
}

/// The columns of a file with their names and units, and its first row.
fn heading(lines: &mut Lines) -> Result<Table, ImportError> {
    let mut above: Vec<Line> = Vec::new();
    let (mut is_labview, mut is_head) = (false, false);
    loop {
        let Some(line) = lines.next_line()? else {
            let Some(header) = above.pop() else {
                let problem = "the file is empty, expected a header and samples";
                return Err(lines.problem(problem.into()));
            };
            return Ok(named(lines, header));
        };
        let line = Line {
            number: line.number(),
            fields: line.fields.to_vec(),
        };
        let width = line.fields.len();
        is_labview |= line.number == 1 && line.fields.join(" ").trim() == LABVIEW;
        is_head |= is_labview && (line.number == 1 || line.fields[0] == SECOND_HEAD);
        if is_head {
            is_head = line.fields[0] != END_OF_HEAD;
            continue;
        }
        // The empty row of a spreadsheet.
        if line.fields.iter().all(String::is_empty) {
            continue;
        }
        let is_wide = |above: &Line| above.fields.len() == width;
        let is_named = above.last().is_some_and(is_wide) || lines.comment().len() == width;
        if !is_data(&line.fields, is_named) {
            above.push(line);
            continue;
        }
        lines.settle();
        // A text that is narrower than the numbers names no columns.
        let ends_empty = line.fields.last().is_some_and(String::is_empty);
        let least = width - usize::from(ends_empty);
        let header = above.pop().filter(|header| header.fields.len() >= least);
        let mut table = match header {
            Some(header) => {
                let names = above
                    .pop()
                    .filter(|names| names.fields.len() == header.fields.len());
                match names.filter(|_| are_units(&header.fields)) {
                    Some(names) => Table {
                        units: header.fields,
                        ..named(lines, names)
                    },
                    None => named(lines, header),
                }
            }
            None => {
                let names = Some(lines.comment()).filter(|names| names.len() == width);
                let numbers = || (1..=width).map(|n| n.to_string()).collect();
                let header = Line {
                    number: line.number,
                    fields: names.unwrap_or_else(numbers),
                };
                named(lines, header)
            }
        };
        let pushed = push(&mut table, line.number, &line.fields);
        return pushed
            .map(|()| table)
            .map_err(|problem| lines.problem(problem));
    }
}

/// A table with these names.
fn named(lines: &Lines, header: Line) -> Table {
    Table {
        path: lines.path().into(),
        header_line: header.number,
        columns: vec![Vec::new(); header.fields.len()],
        radians: names::are_of_ros(&header.fields),
        names: header.fields,
        ..Table::default()
    }
}

/// Whether a line has data: only numbers, or below a header two of them, as beside a column of
/// text.
fn is_data(fields: &[String], is_named: bool) -> bool {
    let numbers = fields
        .iter()
        .filter(|field| number(field).is_some_and(|n| !n.is_nan()));
    let texts = fields.iter().filter(|field| value(field).is_none()).count();
    texts == 0 || is_named && numbers.count() >= 2
}

/// Whether a line has units.
fn are_units(fields: &[String]) -> bool {
    fields.iter().any(|field| unit::is_known(field))
}

/// Appends a row.
fn push(table: &mut Table, line: u64, fields: &[String]) -> Result<(), String> {
    let expected = table.columns.len();
    let fields = match fields.split_last() {
        // A delimiter after the last field.
        Some((last, fields)) if last.is_empty() && fields.len() == expected => fields,
        _ => fields,
    };
    // LabVIEW has a column for comments that most lines lack.
    let lacks_comment = fields.len() + 1 == expected
        && table
            .names
            .last()
            .is_some_and(|name| name.eq_ignore_ascii_case("comment"));
    if fields.len() != expected && !lacks_comment {
        let found = fields.len();
        return Err(format!(
            "the fields are {found}, expected {expected} as in the header"
        ));
    }
    for (index, field) in fields.iter().enumerate() {
        let number = number(field).unwrap_or_else(|| match clock::seconds(field) {
            Some(seconds) => {
                table.set_unit(index, "s");
                seconds
            }
            // A column of text is an error only where it is used.
            None => {
                table.texts.entry(index).or_insert_with(|| field.clone());
                f64::INFINITY
            }
        });
        table.columns[index].push(number);
    }
    if lacks_comment && let Some(comments) = table.columns.last_mut() {
        comments.push(f64::NAN);
    }
    table.lines.push(line);
    Ok(())
}

/// The number or the time in a field.
fn value(field: &str) -> Option<f64> {
    number(field).or_else(|| clock::seconds(field))
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
