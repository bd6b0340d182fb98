//! Opens a file, and determines its format by its content: names are often wrong.
//!
//! Envelopes are removed first: gzip, a zip archive with one file, UTF-16, the sheet of a workbook.
//! Inside is text, or one of the other [`Format`]s.

use std::{
    io::{self, BufRead, BufReader, Cursor, Read},
    path::{Path, PathBuf},
    sync::OnceLock,
};

use flate2::read::GzDecoder;

use super::{ImportError, spreadsheet};
use crate::bounded_file::BoundedFile;

/// The most bytes of a file, also decompressed: more than a MAT file without compression may have.
pub const MOST_BYTES: u64 = 1 << 31;

/// The bytes at the start that determine the format.
const HEAD: usize = 1024;

/// The name of standard input.
const STANDARD_INPUT: &str = "-";

/// The format of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Text with one row in each line.
    Text,
    /// JSON.
    Json,
    /// MAT of level 5.
    Mat,
    /// HDF5, and MAT of version 7.3.
    Hdf5,
    /// Apache Parquet.
    Parquet,
    /// MCAP, as of ROS 2 and Foxglove.
    Mcap,
    /// The log of an ArduPilot autopilot.
    Dataflash,
}

/// Formats that are not read: their first bytes, their name, and what to do.
const UNREADABLE: [(&[u8], &str, &str); 10] = [
    (b"#ROSBAG", "a bag of ROS", TO_CSV),
    (
        b"SQLite format 3",
        "a SQLite database, as bags of ROS 2",
        TO_CSV,
    ),
    (b"ULog\x01\x12\x35", "a ULog file of PX4", TO_CSV),
    (
        b"\x93NUMPY",
        "an array of numpy",
        "expected text, as numpy.savetxt writes it with a header",
    ),
    (
        b"\xd0\xcf\x11\xe0",
        "a workbook of Excel before 2007",
        "expected .xlsx or .csv",
    ),
    (b"ARROW1", "an Arrow file", "expected Parquet or CSV"),
    (b"BZh", "a bzip2 file", UNPACKED),
    (b"\xfd7zXZ", "an xz file", UNPACKED),
    (b"\x28\xb5\x2f\xfd", "a zstd file", UNPACKED),
    (b"7z\xbc\xaf", "a 7z archive", UNPACKED),
];
const TO_CSV: &str = "expected CSV, as PlotJuggler exports it";
const UNPACKED: &str = "expected it unpacked, or as gzip or zip";

/// An opened file without its envelopes.
pub struct Source {
    /// The file.
    pub path: PathBuf,
    /// The format of the content.
    pub format: Format,
    /// The size of the file, bytes; that of the content where the content is in memory.
    pub size: u64,
    reader: Box<dyn BufRead>,
}

impl Source {
    /// Opens a file, or standard input for `-`.
    ///
    /// # Errors
    /// [`ImportError::Read`], and [`ImportError::Content`] for a format that is not read.
    pub fn open(path: &Path) -> Result<Self, ImportError> {
        let read = |source| ImportError::Read {
            path: path.into(),
            source,
        };
        let (size, reader): (u64, Box<dyn BufRead>) = if path == Path::new(STANDARD_INPUT) {
            let bytes = standard_input().map_err(read)?;
            (bytes.len() as u64, Box::new(Cursor::new(bytes)))
        } else {
            let file = BoundedFile::open(path, MOST_BYTES).map_err(read)?;
            let size = std::fs::metadata(path).map_or(0, |file| file.len());
            (size, Box::new(BufReader::with_capacity(1 << 16, file)))
        };
        let source = Self {
            path: path.into(),
            format: Format::Text,
            size,
            reader,
        };
        source.without_envelopes()
    }

    /// Removes one envelope after the other, and determines the format of the content.
    fn without_envelopes(mut self) -> Result<Self, ImportError> {
        let head = match self.reader.fill_buf() {
            Ok(head) => head.get(..HEAD).unwrap_or(head).to_vec(),
            Err(error) => return Err(self.unread(error)),
        };
        match &head[..] {
            [0x1f, 0x8b, ..] => {
                let bytes = unpacked(GzDecoder::new(&mut self.reader));
                let bytes = bytes.map_err(|problem| self.problem(problem))?;
                self.with(bytes).without_envelopes()
            }
            [b'P', b'K', 3, 4, ..] => {
                let bytes = self.bytes()?;
                let unpacked = unzipped(bytes).map_err(|problem| self.problem(problem))?;
                self.with(unpacked).without_envelopes()
            }
            [0xff, 0xfe, ..] => self.decoded(u16::from_le_bytes),
            [0xfe, 0xff, ..] => self.decoded(u16::from_be_bytes),
            // Without a byte order mark: text as ASCII has it, with the upper byte second.
            [32..127, 0, 32..127, 0, 32..127, 0, ..] => self.decoded(u16::from_le_bytes),
            head => {
                self.format = format(head).map_err(|problem| self.problem(problem))?;
                Ok(self)
            }
        }
    }

    /// Decodes UTF-16.
    fn decoded(mut self, unit: fn([u8; 2]) -> u16) -> Result<Self, ImportError> {
        let bytes = self.bytes()?;
        let (units, _) = bytes.as_chunks();
        let units: Vec<u16> = units.iter().map(|pair| unit(*pair)).collect();
        self.with(String::from_utf16_lossy(&units).into_bytes())
            .without_envelopes()
    }

    /// The same file with this content.
    fn with(self, bytes: Vec<u8>) -> Self {
        Self {
            size: bytes.len() as u64,
            reader: Box::new(Cursor::new(bytes)),
            ..self
        }
    }

    /// The rest of the content.
    ///
    /// # Errors
    /// [`ImportError::Read`].
    pub fn bytes(&mut self) -> Result<Vec<u8>, ImportError> {
        let mut bytes = Vec::new();
        let read = self.reader.read_to_end(&mut bytes);
        read.map_err(|source| self.unread(source))?;
        Ok(bytes)
    }

    /// The content.
    pub fn reader(&mut self) -> &mut dyn BufRead {
        &mut self.reader
    }

    /// The error for a content that cannot be read.
    pub fn unread(&self, source: io::Error) -> ImportError {
        ImportError::Read {
            path: self.path.clone(),
            source,
        }
    }

    fn problem(&self, problem: String) -> ImportError {
        ImportError::Content {
            path: self.path.clone(),
            line: 1,
            problem,
        }
    }
}

/// Standard input, which is kept: it can be read once, and some commands read their files twice.
fn standard_input() -> io::Result<&'static [u8]> {
    static INPUT: OnceLock<Vec<u8>> = OnceLock::new();
    if let Some(bytes) = INPUT.get() {
        return Ok(bytes);
    }
    let mut bytes = Vec::new();
    io::stdin().take(MOST_BYTES).read_to_end(&mut bytes)?;
    if bytes.len() as u64 == MOST_BYTES {
        return Err(io::Error::other(format!("{MOST_BYTES} bytes or more")));
    }
    Ok(INPUT.get_or_init(|| bytes))
}

/// The only file of an archive, or the text of a workbook.
fn unzipped(bytes: Vec<u8>) -> Result<Vec<u8>, String> {
    let damaged = |error: &dyn std::error::Error| format!("a damaged zip archive: {error}");
    let mut archive = zip::ZipArchive::new(Cursor::new(&bytes)).map_err(|e| damaged(&e))?;
    let all = archive
        .file_names()
        .filter_map(|name| Some(name.ok()?.into_owned()));
    let names = all.filter(|name| !name.ends_with('/') && !name.starts_with("__MACOSX"));
    let names: Vec<String> = names.collect();
    if names.iter().any(|name| name == "xl/workbook.xml") {
        return spreadsheet::text(bytes);
    }
    let [name] = &names[..] else {
        let (count, names) = (names.len(), names.join(", "));
        return Err(format!(
            "a zip archive with {count} files, expected one: {names}"
        ));
    };
    unpacked(archive.by_name(name).map_err(|e| damaged(&e))?)
}

/// The content of an envelope.
fn unpacked(envelope: impl Read) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    let read = envelope.take(MOST_BYTES).read_to_end(&mut bytes);
    read.map_err(|error| format!("it cannot be unpacked: {error}"))?;
    if bytes.len() as u64 == MOST_BYTES {
        return Err(format!("it unpacks to {MOST_BYTES} bytes or more"));
    }
    Ok(bytes)
}

/// The format of a content that starts with these bytes.
fn format(head: &[u8]) -> Result<Format, String> {
    const HDF5: &[u8] = b"\x89HDF\r\n\x1a\n";
    let starts = |magic: &&[u8]| head.starts_with(magic);
    if let Some((_, what, expected)) = UNREADABLE.iter().find(|(magic, ..)| starts(magic)) {
        return Err(format!("{what}, {expected}"));
    }
    // A MAT file of version 7.3 has its own head before that of HDF5.
    if head.starts_with(HDF5) || head.get(512..).is_some_and(|rest| rest.starts_with(HDF5)) {
        return Ok(Format::Hdf5);
    }
    if head.starts_with(b"MATLAB ") || head.get(124..128) == Some(b"\x00\x01IM") {
        return Ok(Format::Mat);
    }
    if head.starts_with(b"PAR1") {
        return Ok(Format::Parquet);
    }
    if head.starts_with(b"\x89MCAP") {
        return Ok(Format::Mcap);
    }
    if head.starts_with(b"\xa3\x95") {
        return Ok(Format::Dataflash);
    }
    let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
    let mut content = text.iter().filter(|byte| !byte.is_ascii_whitespace());
    match (content.next(), content.next()) {
        (Some(b'{'), _) => Ok(Format::Json),
        // A header may start with the unit in brackets.
        (Some(b'['), Some(b'{' | b'[' | b']' | b'-' | b'0'..=b'9')) => Ok(Format::Json),
        _ => Ok(Format::Text),
    }
}
