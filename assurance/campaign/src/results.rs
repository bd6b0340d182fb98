//! The results of a campaign in a CSV file.

use std::fs::File;
use std::path::Path;

use cross_build::board_elf;
use program_image::ImageError;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::injection::{Injection, Place};
use crate::motion::Motion;
use crate::outcome::{Outcome, Verdict};

/// A result.
#[derive(Debug, Serialize, Deserialize)]
struct Line {
    place: Place,
    number: u64,
    motion: Motion,
    address: String,
    bit: u8,
    at_ms: u32,
    instructions: u32,
    outcome: Outcome,
    detected_ms: Option<u32>,
    safe_ms: u32,
    pc: u32,
}

/// A file to which results are written as they come.
#[derive(Debug)]
pub struct Results(csv::Writer<File>);

impl Results {
    /// A new file.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn create(path: &Path) -> csv::Result<Self> {
        csv::Writer::from_path(path).map(Self)
    }

    /// Writes a result.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn add(&mut self, injection: &Injection, verdict: Verdict) -> csv::Result<()> {
        self.0.serialize(Line {
            place: injection.place,
            number: injection.number,
            motion: injection.motion,
            address: format!("{:08x}", injection.address),
            bit: injection.bit,
            at_ms: injection.at_ms,
            instructions: injection.instructions,
            outcome: verdict.outcome,
            detected_ms: verdict.detected_ms,
            safe_ms: verdict.safe_ms,
            pc: verdict.pc,
        })?;
        Ok(self.0.flush()?)
    }
}

/// First bytes of the hash of the flashed program: not of the ELF file, whose line numbers change
/// with comments.
///
/// # Errors
/// The program cannot be read.
pub fn program() -> Result<String, ImageError> {
    let hash = Sha256::digest(program_image::flash(board_elf())?);
    Ok(hash[..8].iter().map(|byte| format!("{byte:02x}")).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_result_is_a_line_with_its_address_and_outcome() {
        let path = tempfile::NamedTempFile::new().unwrap();
        let mut results = Results::create(path.path()).unwrap();
        let injection = Injection::of_byte(1, 0x2000_0010);
        let verdict = Verdict {
            outcome: Outcome::Detected,
            detected_ms: Some(4),
            ..Verdict::UNJUDGED
        };
        results.add(&injection, verdict).unwrap();
        let mut lines = csv::Reader::from_path(path.path()).unwrap();
        let lines: Vec<Line> = lines.deserialize().map(Result::unwrap).collect();
        assert_eq!(lines.len(), 1);
        assert_eq!(lines[0].address, "20000010");
        assert_eq!(
            (lines[0].outcome, lines[0].detected_ms),
            (Outcome::Detected, Some(4))
        );
    }
}
