//! The undisturbed twin of an experiment: the same board, in a copy without an injection.

use crate::fork::Reporter;

/// The angles of the twin, one at the start of each millisecond after power-on, deg.
pub type Twin = Vec<f64>;

/// The twin of these bytes.
pub fn from_bytes(bytes: &[u8]) -> Twin {
    let angles = bytes.as_chunks().0.iter();
    angles.map(|bytes| f64::from_le_bytes(*bytes)).collect()
}

/// Records the twin.
#[derive(Debug)]
pub struct Recorder {
    bytes: Vec<u8>,
    until_ms: u32,
    reporter: Option<Reporter>,
}

impl Recorder {
    /// Records until this time after power-on, and reports the twin.
    pub fn new(until_ms: u32, reporter: Reporter) -> Self {
        Self {
            bytes: Vec::new(),
            until_ms,
            reporter: Some(reporter),
        }
    }

    /// Records this millisecond. At the end, it ends this process.
    pub fn record(&mut self, angle_deg: f64, ms: u32) {
        self.bytes.extend(angle_deg.to_le_bytes());
        if let Some(reporter) = self.reporter.take_if(|_| ms >= self.until_ms) {
            reporter.end(&self.bytes);
        }
    }
}
