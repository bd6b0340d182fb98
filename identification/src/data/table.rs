//! Named columns of numbers, as read from a file.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use super::{
    Delimiter, Format, ImportError, Progress, Quantity, Source, dataflash, delimited, hdf5, json,
    mat, mcap, parquet,
};

/// The numbers of a file, with the line of each row.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// The file.
    pub path: PathBuf,
    /// The line of the header, counted from 1.
    pub header_line: u64,
    /// Names of the columns; their numbers from 1 where there is no header.
    pub names: Vec<String>,
    /// Units of the columns from a line of units; empty without such a line.
    pub units: Vec<String>,
    /// The columns. NaN is a missing number.
    pub columns: Vec<Vec<f64>>,
    /// The line of each row, counted from 1.
    pub lines: Vec<u64>,
    /// Number of the first columns that are of one group; a quantity is looked for in them first.
    pub own_columns: usize,
    /// Two groups that may both be the recording.
    pub rivals: Option<[String; 2]>,
    /// The first text of a column where a number is expected, by the index of the column.
    pub texts: BTreeMap<usize, String>,
    /// Numbers that apply to the whole file.
    pub constants: BTreeMap<String, f64>,
    /// Whether angles without a unit are in radians.
    pub radians: bool,
    /// Columns that are left out, with the reason.
    pub left_out: Vec<String>,
    /// Irregularities by line.
    pub notes: Vec<(u64, String)>,
}

/// Share of the samples that a column may lack at its end.
const SHORTER: f64 = 0.01;

/// A column with its name.
pub type Column = (String, Vec<f64>);

/// Columns beside each other, with the name of the struct or group that they are in.
pub type Group = (String, Vec<Column>);

impl Table {
    /// Reads a file; the delimiter is that of a text file.
    ///
    /// # Errors
    /// [`ImportError::Read`], and [`ImportError::Content`] for a file of another format, and a
    /// field that is not a number.
    pub fn read(
        path: &Path,
        delimiter: Option<Delimiter>,
        progress: &mut Progress<'_>,
    ) -> Result<Self, ImportError> {
        Self::of(Source::open(path)?, delimiter, progress)
    }

    /// Reads an opened file, as [`Table::read`].
    ///
    /// # Errors
    /// Those of [`Table::read`].
    pub fn of(
        mut source: Source,
        delimiter: Option<Delimiter>,
        progress: &mut Progress<'_>,
    ) -> Result<Self, ImportError> {
        let read: fn(Vec<u8>, Table) -> Result<Table, ImportError> = match source.format {
            Format::Text => return delimited::read(source, delimiter, progress),
            Format::Json => json::read,
            Format::Mat => |bytes, table| table.with(mat::groups(&bytes)),
            Format::Hdf5 => |bytes, table| table.with(hdf5::groups(bytes)),
            Format::Parquet => parquet::read,
            Format::Mcap => mcap::read,
            Format::Dataflash => |bytes, table| Ok(dataflash::read(&bytes, table)),
        };
        let bytes = source.bytes()?;
        progress(source.size, source.size);
        let table = Self {
            path: source.path,
            header_line: 1,
            ..Self::default()
        };
        read(bytes, table)
    }

    /// This table with the columns of several groups: first those of the group with the most
    /// quantities, or the longest one, then those of the others that have its length. Columns that
    /// are a little shorter lack their last samples; those of another length are left out.
    ///
    /// # Errors
    /// [`ImportError::Content`] with the problem of the groups.
    pub fn with(mut self, groups: Result<Vec<Group>, String>) -> Result<Self, ImportError> {
        let groups = groups.map_err(|problem| self.problem(1, problem))?;
        let mut groups: Vec<(usize, usize, Group)> = groups
            .into_iter()
            .map(|group| (quantities(&group), longest(&group), group))
            .collect();
        groups.sort_by_key(|(quantities, rows, _)| std::cmp::Reverse((*quantities, *rows)));
        let (quantities, rows) = groups.first().map_or((0, 0), |(q, rows, _)| (*q, *rows));
        self.rivals = match &groups[..] {
            [(.., (a, _)), (q, r, (b, _)), ..] if (*q, *r) == (quantities, rows) && *q == 2 => {
                Some([a.clone(), b.clone()])
            }
            _ => None,
        };
        self.own_columns = groups.first().map_or(0, |(.., (_, own))| own.len());
        // A group alone needs no name.
        let is_alone = groups.iter().filter(|(_, own, _)| *own == rows).count() < 2;
        let named = |(_, own, (group, columns)): (usize, usize, Group)| {
            let prefix = match group.is_empty() || (is_alone && own == rows) {
                true => String::new(),
                false => format!("{group}."),
            };
            let of = move |(name, column)| (format!("{prefix}{name}"), column);
            columns.into_iter().map(of)
        };
        for (name, mut column) in groups.into_iter().flat_map(named) {
            // A group with fewer quantities may be longer.
            let missing = rows.saturating_sub(column.len());
            if 0 < missing && (missing as f64) < SHORTER * rows as f64 {
                let samples = if missing == 1 { "sample" } else { "samples" };
                let text = format!("column `{name}` ends {missing} {samples} before the others");
                self.notes.push((1, text));
                column.resize(rows, f64::NAN);
            }
            if column.len() == rows {
                self.names.push(name);
                self.columns.push(column);
            } else {
                let found = format!("`{name}` with {} samples", column.len());
                // A single number is a parameter.
                if column.len() > 1 {
                    let text = format!("column {found} is left out: others have {rows}");
                    self.notes.push((1, text));
                }
                self.left_out.push(found);
            }
        }
        // Rows have no lines: they are counted.
        self.lines = (1..=rows as u64).collect();
        Ok(self)
    }

    /// Appends a row of values by name. A new column is filled with missing numbers; the first of
    /// several values with the same name applies.
    pub fn push(&mut self, line: u64, row: impl IntoIterator<Item = (String, f64)>) {
        let rows = self.lines.len();
        for (place, (name, value)) in row.into_iter().enumerate() {
            // Most rows have the same names in the same order.
            let is_it = |index: &usize| self.names[*index] == name;
            let known = Some(place)
                .filter(|&place| place < self.names.len())
                .filter(is_it);
            let known = known.or_else(|| (0..self.names.len()).find(|index| is_it(index)));
            let index = known.unwrap_or_else(|| {
                self.names.push(name);
                self.columns.push(vec![f64::NAN; rows]);
                self.names.len() - 1
            });
            if self.columns[index].len() == rows {
                self.columns[index].push(value);
            }
        }
        for column in &mut self.columns {
            column.resize(rows + 1, f64::NAN);
        }
        self.lines.push(line);
    }

    /// Sets the unit of a column.
    pub fn set_unit(&mut self, index: usize, unit: &str) {
        self.units.resize(self.names.len(), String::new());
        if self.units[index] != unit {
            unit.clone_into(&mut self.units[index]);
        }
    }

    /// The names of the columns, for messages.
    pub fn described(&self) -> String {
        let names = self.names.join("`, `");
        let left_out = match &self.left_out[..] {
            [] => String::new(),
            all => format!(
                "; left out are {}, where others have {}",
                all.join(", "),
                self.len()
            ),
        };
        format!("the columns are `{names}`{left_out}")
    }

    /// A problem at a line.
    pub fn problem(&self, line: u64, problem: impl Into<String>) -> ImportError {
        ImportError::Content {
            path: self.path.clone(),
            line: line.max(1),
            problem: problem.into(),
        }
    }

    /// The line of a row; that of the header beyond the last.
    pub fn line(&self, row: usize) -> u64 {
        self.lines.get(row).copied().unwrap_or(self.header_line)
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.lines.len()
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.lines.is_empty()
    }
}

/// How many of command and angle are in a group.
fn quantities((_, columns): &Group) -> usize {
    let names: Vec<String> = columns.iter().map(|(name, _)| name.clone()).collect();
    let is_in = |quantity: &Quantity| !matches!(quantity.find(&names), Ok(None));
    [Quantity::Command, Quantity::Angle]
        .iter()
        .filter(|q| is_in(q))
        .count()
}

fn longest((_, columns): &Group) -> usize {
    columns
        .iter()
        .map(|(_, column)| column.len())
        .max()
        .unwrap_or(0)
}
