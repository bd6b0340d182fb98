//! Reads the non-blank lines of a CSV file with their numbers.
//!
//! The `csv` crate would not limit the length of a line, and misnumbers lines after blank ones.

use std::{
    borrow::Cow,
    io::{BufRead, Read},
    path::Path,
};

use super::{ImportError, Source};

/// The longest line, bytes: a file without line ends is refused instead of filling the memory.
const LONGEST: usize = 1 << 16;

/// The delimiter between two fields.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Delimiter {
    /// This character, outside quotes.
    Character(u8),
    /// Any number of blanks.
    Blanks,
}

impl Delimiter {
    /// The most likely delimiter of a line. A semicolon takes precedence over a comma, which may be
    /// a decimal comma.
    pub fn of(line: &str) -> Self {
        let character = b";\t,".iter().copied();
        let mut found = character.filter(|&c| line.contains(char::from(c)));
        found.next().map_or(Self::Blanks, Self::Character)
    }
}

/// Characters that start a comment: of numpy and gnuplot, and of MATLAB.
const COMMENTS: [char; 2] = ['#', '%'];

/// A file that is read line by line.
pub struct Lines {
    source: Source,
    number: u64,
    /// Bytes read so far.
    pub read: u64,
    text: Vec<u8>,
    /// Those of the last line. Reused, because the allocation of each field is slow.
    fields: Vec<String>,
    /// Detected in each line until it is settled, where it is not given.
    delimiter: Option<Delimiter>,
    is_settled: bool,
    /// The last comment before the delimiter is settled.
    comment: String,
    /// Reused, because its construction is slow.
    reader: csv_core::Reader,
}

/// A line that is neither blank nor a comment.
pub struct TextLine<'a> {
    path: &'a Path,
    number: u64,
    /// Its fields without quotes and surrounding blanks.
    pub fields: &'a [String],
}

impl Lines {
    /// The lines of a text with this delimiter, or the one that is detected in its lines.
    pub fn new(source: Source, delimiter: Option<Delimiter>) -> Self {
        Self {
            source,
            number: 0,
            read: 0,
            text: Vec::new(),
            fields: Vec::new(),
            reader: reader(delimiter),
            is_settled: delimiter.is_some(),
            delimiter,
            comment: String::new(),
        }
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.source.path
    }

    /// The delimiter of the line before is that of all that follow.
    pub fn settle(&mut self) {
        self.is_settled = true;
    }

    /// The fields of the last comment before the delimiter was settled: it may be a header.
    pub fn comment(&self) -> Vec<String> {
        let mut names = Vec::new();
        match Delimiter::of(&self.comment) {
            Delimiter::Blanks => set(&mut names, self.comment.split_whitespace()),
            Delimiter::Character(at) => {
                set(
                    &mut names,
                    self.comment.split(char::from(at)).map(str::trim),
                );
            }
        }
        names
    }

    /// The next line that is neither blank nor a comment.
    ///
    /// # Errors
    /// [`ImportError::Read`], and [`ImportError::Content`] for a line that is not text.
    pub fn next_line(&mut self) -> Result<Option<TextLine<'_>>, ImportError> {
        while self.advance()? {
            if self.split()? {
                return Ok(Some(TextLine {
                    path: &self.source.path,
                    number: self.number,
                    fields: &self.fields,
                }));
            }
        }
        Ok(None)
    }

    /// Splits the line into its fields; false if it is blank, a comment, or Excel's `sep=;`.
    fn split(&mut self) -> Result<bool, ImportError> {
        let Some(text) = decoded(&self.text) else {
            let problem = "a line with a byte of zero, expected text, JSON, MAT, Parquet or xlsx";
            return Err(self.problem(problem.into()));
        };
        let text = text
            .trim_start_matches('\u{feff}')
            .trim_matches(['\r', '\n', ' ']);
        let content = text.trim_start();
        if content.is_empty() || content.starts_with(COMMENTS) {
            if !self.is_settled && !content.is_empty() {
                self.comment = content.trim_start_matches(COMMENTS).trim().to_owned();
            }
            return Ok(false);
        }
        if !self.is_settled {
            if let Some(&[delimiter]) = content.strip_prefix("sep=").map(str::as_bytes) {
                self.delimiter = Some(Delimiter::Character(delimiter));
                self.reader = reader(self.delimiter);
                self.is_settled = true;
                return Ok(false);
            }
            let delimiter = Some(Delimiter::of(text));
            if self.delimiter != delimiter {
                self.delimiter = delimiter;
                self.reader = reader(delimiter);
            }
        }
        match self.delimiter {
            Some(Delimiter::Blanks) => set(&mut self.fields, text.split_whitespace()),
            Some(Delimiter::Character(at)) if !text.contains(['"', '\r']) => {
                set(&mut self.fields, text.split(char::from(at)).map(str::trim));
            }
            _ => match fields(&mut self.reader, text) {
                Some(fields) => self.fields = fields,
                None => {
                    let problem = "a quote is not closed, expected its end in the same line";
                    return Err(self.problem(problem.into()));
                }
            },
        }
        Ok(true)
    }

    /// Reads the next line into `text`; false at the end of the file.
    fn advance(&mut self) -> Result<bool, ImportError> {
        self.text.clear();
        let mut part = self.source.reader().take(LONGEST as u64);
        let length = part.read_until(b'\n', &mut self.text);
        let length = length.map_err(|error| self.source.unread(error))?;
        self.number += u64::from(length > 0);
        self.read += length as u64;
        if length == LONGEST {
            let problem = format!("more than {LONGEST} bytes in a line, expected CSV text");
            return Err(self.problem(problem));
        }
        Ok(length > 0)
    }

    /// A problem in the line that was read last.
    pub fn problem(&self, problem: String) -> ImportError {
        ImportError::Content {
            path: self.source.path.clone(),
            line: self.number.max(1),
            problem,
        }
    }
}

/// The text of a line, in UTF-8 or, where it is not, in Latin-1 with its `°`; `None` with a byte of
/// zero.
fn decoded(line: &[u8]) -> Option<Cow<'_, str>> {
    if line.contains(&0) {
        return None;
    }
    Some(match str::from_utf8(line) {
        Ok(text) => text.into(),
        Err(_) => line.iter().map(|byte| char::from(*byte)).collect(),
    })
}

/// A reader of fields with this delimiter.
fn reader(delimiter: Option<Delimiter>) -> csv_core::Reader {
    match delimiter {
        Some(Delimiter::Character(character)) => {
            csv_core::ReaderBuilder::new().delimiter(character).build()
        }
        _ => csv_core::Reader::new(),
    }
}

impl TextLine<'_> {
    /// Its number, counted from 1.
    pub fn number(&self) -> u64 {
        self.number
    }

    /// A problem in this line.
    pub fn problem(&self, problem: String) -> ImportError {
        ImportError::Content {
            path: self.path.into(),
            line: self.number,
            problem,
        }
    }
}

/// Makes these the fields, in the memory of those before.
fn set<'a>(fields: &mut Vec<String>, texts: impl Iterator<Item = &'a str>) {
    let mut count = 0;
    for text in texts {
        match fields.get_mut(count) {
            Some(field) => {
                field.clear();
                field.push_str(text);
            }
            None => fields.push(text.to_owned()),
        }
        count += 1;
    }
    fields.truncate(count);
}

/// The fields of a line; `None` if a quote is not closed.
fn fields(reader: &mut csv_core::Reader, line: &str) -> Option<Vec<String>> {
    let line = [line.as_bytes(), b"\n"].concat();
    // The fields are not longer than the line, nor more than its characters.
    let (mut text, mut ends) = (vec![0; line.len()], vec![0; line.len()]);
    reader.reset();
    let (result, _, _, count) = reader.read_record(&line, &mut text, &mut ends);
    // Within quotes a line end does not end the record.
    if !matches!(result, csv_core::ReadRecordResult::Record) {
        return None;
    }
    let starts = std::iter::once(&0).chain(&ends);
    let field = |(start, end): (&usize, &usize)| {
        String::from_utf8_lossy(&text[*start..*end])
            .trim()
            .to_owned()
    };
    Some(starts.zip(&ends[..count]).map(field).collect())
}

#[cfg(test)]
mod tests {
    use super::fields;

    fn split(line: &str) -> Vec<String> {
        fields(&mut csv_core::Reader::new(), line).expect("the quotes are closed")
    }

    #[test]
    fn fields_end_at_commas_that_stand_in_no_quotes() {
        assert_eq!(split("1,2,"), ["1", "2", ""]);
        assert_eq!(split(r#""a, b","" ,3"#), ["a, b", "", "3"]);
    }

    #[test]
    fn a_doubled_quote_within_quotes_is_one() {
        assert_eq!(split(r#""5"" pipe","""""#), [r#"5" pipe"#, r#"""#]);
        assert_eq!(fields(&mut csv_core::Reader::new(), r#""a,b"#), None);
    }
}
