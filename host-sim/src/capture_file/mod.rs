//! The capture of the board as a file: text with one line per record.
//!
//! ```text
//! # Capture of the board, form 1: a record each 4000 us.
//! time_us,angle_mdeg,command_mdeg
//! 0,12,0
//! 4000,12,90000
//! ```
//!
//! The numbers are those of the board, integers in the unit at the end of their column's name
//! ([`Signal::column`]); the time counts from the first record. `actuator identify` reads the
//! file, as does any CSV reader that ignores lines with `#`.

mod reader;
#[cfg(test)]
mod tests;

use std::fmt::Write as _;

use firmware::capture::Signal;
pub use reader::{ReadError, Reader};

/// The control period, us.
const PERIOD_US: u64 = 4000;

/// A capture.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct CaptureFile {
    /// The signals of a record.
    pub signals: Vec<Signal>,
    /// Control periods from record to record.
    pub decimation: u16,
    /// The values, record by record.
    pub values: Vec<i32>,
}

impl CaptureFile {
    /// Number of records.
    ///
    /// ```
    /// use firmware::capture::Signal;
    /// use host_sim::capture_file::CaptureFile;
    ///
    /// let signals = vec![Signal::Angle, Signal::Command];
    /// let capture = CaptureFile { signals, decimation: 1, values: vec![12, 0, 12, 90_000] };
    /// assert_eq!(capture.len(), 2);
    /// assert!(capture.text().ends_with("\n4000,12,90000\n"));
    /// ```
    pub fn len(&self) -> usize {
        self.values.len() / self.signals.len().max(1)
    }

    /// Whether there is no record.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The text of the file.
    pub fn text(&self) -> String {
        let step_us = PERIOD_US * u64::from(self.decimation.max(1));
        let mut text = format!("# Capture of the board, form 1: a record each {step_us} us.\n");
        text += "time_us";
        for signal in &self.signals {
            let _ = write!(text, ",{}", signal.column());
        }
        text.push('\n');
        let records = self.values.chunks_exact(self.signals.len().max(1));
        for (record, time_us) in records.zip((0..).step_by(step_us as usize)) {
            let _ = write!(text, "{time_us}");
            for value in record {
                let _ = write!(text, ",{value}");
            }
            text.push('\n');
        }
        text
    }
}
