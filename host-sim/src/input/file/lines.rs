//! The lines of a CSV file that hold something, each with its number.

use std::{
    fs::File,
    io::{BufRead, BufReader, Read},
    path::Path,
};

use csv::{ReaderBuilder, StringRecord, Trim};

use crate::error::Error;

/// The longest line, bytes: a file without line ends is given up here, not when memory is.
const LONGEST: usize = 1 << 16;

/// A file that is read line by line.
pub struct Lines<'a> {
    path: &'a Path,
    file: BufReader<File>,
    number: u64,
    text: Vec<u8>,
    csv: ReaderBuilder,
}

/// A line that holds something.
pub struct Line<'a> {
    path: &'a Path,
    number: u64,
    /// Its fields without quotes and without blanks around them.
    pub fields: StringRecord,
}

impl<'a> Lines<'a> {
    /// Opens a file.
    pub fn open(path: &'a Path) -> Result<Self, Error> {
        let file = File::open(path).map_err(|source| Error::Read {
            path: path.into(),
            source,
        })?;
        let mut csv = ReaderBuilder::new();
        // A small buffer: every line gets a reader of its own.
        csv.has_headers(false).trim(Trim::All).buffer_capacity(256);
        Ok(Self {
            path,
            file: BufReader::new(file),
            number: 0,
            text: Vec::new(),
            csv,
        })
    }

    /// The next line that is neither blank nor a comment.
    pub fn next(&mut self) -> Result<Option<Line<'a>>, Error> {
        while self.advance()? {
            let text = str::from_utf8(&self.text)
                .map_err(|error| self.problem(format!("{error}, expected UTF-8 text")))?;
            let text = text.trim_start_matches('\u{feff}').trim();
            if text.is_empty() || text.starts_with('#') {
                continue;
            }
            return self.split(text).map(Some);
        }
        Ok(None)
    }

    /// Takes the next line into `text`; false at the end of the file.
    fn advance(&mut self) -> Result<bool, Error> {
        self.text.clear();
        let mut part = self.file.by_ref().take(LONGEST as u64);
        let length = part
            .read_until(b'\n', &mut self.text)
            .map_err(|source| Error::Read {
                path: self.path.into(),
                source,
            })?;
        self.number += u64::from(length > 0);
        if length == LONGEST {
            let problem = format!("more than {LONGEST} bytes in a line, expected CSV text");
            return Err(self.problem(problem));
        }
        Ok(length > 0)
    }

    fn split(&self, text: &str) -> Result<Line<'a>, Error> {
        if !text.matches('"').count().is_multiple_of(2) {
            let problem = "a quote is not closed, expected its end in the same line";
            return Err(self.problem(problem.into()));
        }
        let mut fields = StringRecord::new();
        self.csv
            .from_reader(text.as_bytes())
            .read_record(&mut fields)
            .map_err(|error| self.problem(format!("{error}, expected CSV text")))?;
        Ok(Line {
            path: self.path,
            number: self.number,
            fields,
        })
    }

    /// What is wrong with the line that was read last.
    pub fn problem(&self, problem: String) -> Error {
        Error::InputFile {
            path: self.path.into(),
            line: self.number.max(1),
            problem,
        }
    }
}

impl Line<'_> {
    /// What is wrong with this line.
    pub fn problem(&self, problem: String) -> Error {
        Error::InputFile {
            path: self.path.into(),
            line: self.number,
            problem,
        }
    }
}
