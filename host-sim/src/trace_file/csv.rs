//! Comma-separated numbers, each with the fewest digits that represent it exactly.

use std::io::{self, Write};

/// A writer of CSV.
pub struct Csv<W> {
    out: W,
    line: String,
}

impl<W: Write> Csv<W> {
    /// Writes the header.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn create(mut out: W, columns: &[&str]) -> io::Result<Self> {
        let line = columns.join(",") + "\n";
        out.write_all(line.as_bytes())?;
        Ok(Self { out, line })
    }

    /// Writes a row.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn row(&mut self, values: &[f64]) -> io::Result<()> {
        self.line.clear();
        let mut digits = zmij::Buffer::new();
        for value in values {
            let digits = digits.format(*value);
            self.line += digits.strip_suffix(".0").unwrap_or(digits);
            self.line.push(',');
        }
        self.line.pop();
        self.line.push('\n');
        self.out.write_all(self.line.as_bytes())
    }

    /// The underlying writer.
    pub fn finish(self) -> W {
        self.out
    }
}
