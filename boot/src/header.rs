//! The header of an image.
//!
//! | offset | bytes | content |
//! |---|---|---|
//! | 0 | 4 | [`MAGIC`] |
//! | 4 | 4 | format of the header, 1 |
//! | 8 | 4 | length of the program, bytes, a multiple of 4 |
//! | 12 | 4 | hardware: the product code, object 1018h:2 |
//! | 16 | 4 | [`Version`] |
//! | 20 | 4 | version that a recovery image replaces; 0 in any other image |
//! | 24 | 4 | CRC-32 of the program, checked at each start |
//! | 28 | 4 | number of the key: the first four bytes of the public key |
//! | 32 | 64 | SHA-512 of the program |
//! | 96 | 64 | Ed25519 signature of the bytes 0 to 95 |
//! | 160 | 4 | CRC-32 of the bytes 0 to 159 |
//!
//! Numbers are little endian. The program follows [`HEADER_SIZE`] bytes behind the start of the
//! header, because a vector table must be aligned to its size; the bytes between are erased.

use core::fmt;

use crc::{CRC_32_ISO_HDLC, Crc, Table};

/// Distance of the program from the start of its header, bytes.
pub const HEADER_SIZE: u32 = 512;

/// Bytes of the header that the signature covers.
pub const SIGNED: usize = 96;

/// Bytes of the header before its CRC.
const COVERED: usize = SIGNED + 64;

/// Bytes of the header that are not erased.
const USED: usize = COVERED + 4;

/// The first word, "SAIM".
pub const MAGIC: u32 = u32::from_le_bytes(*b"SAIM");

/// Format of the header.
const FORMAT: u32 = 1;

/// The CRC-32 of headers and programs.
pub static CRC: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);

/// A version: 8 bits, 12 bits, 12 bits. A later version is a greater number.
///
/// ```
/// use bootloader::Version;
///
/// let version = Version::parse("1.20.300").unwrap();
/// assert!(version > Version::parse("1.3.4000").unwrap());
/// assert_eq!(version.to_string(), "1.20.300");
/// assert_eq!(Version::parse("1.2"), None);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Version(pub u32);

impl Version {
    /// The version of a text; `None` if it is not of the form `1.2.3` or a number is too large.
    pub fn parse(text: &str) -> Option<Self> {
        let mut numbers = text.split('.');
        let mut next = |bits: u32| {
            let number: u32 = numbers.next()?.parse().ok()?;
            (number < 1 << bits).then_some(number)
        };
        let version = next(8)? << 24 | next(12)? << 12 | next(12)?;
        numbers.next().is_none().then_some(Self(version))
    }
}

impl fmt::Display for Version {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(version) = *self;
        let (minor, patch) = (version >> 12 & 0xfff, version & 0xfff);
        write!(f, "{}.{minor}.{patch}", version >> 24)
    }
}

/// The header of an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Header {
    /// Length of the program, bytes.
    pub length: u32,
    /// The hardware for which the program is.
    pub hardware: u32,
    /// Its version.
    pub version: Version,
    /// The version that this recovery image may replace although it is later; 0.0.0 for any other
    /// image.
    pub replaces: Version,
    /// CRC-32 of the program.
    pub program_crc: u32,
    /// Number of the key.
    pub key: u32,
    /// SHA-512 of the program.
    pub hash: [u8; 64],
    /// Signature of the bytes before it.
    pub signature: [u8; 64],
}

impl Header {
    /// The header at the start of an image; `None` if there is no header, it is of another format,
    /// or its CRC is wrong.
    pub fn read(image: &[u8]) -> Option<Self> {
        let word = |at: usize| {
            let bytes = image.get(at..)?.first_chunk()?;
            Some(u32::from_le_bytes(*bytes))
        };
        let is_one = word(0)? == MAGIC && word(4)? == FORMAT;
        if !is_one || word(COVERED)? != CRC.checksum(image.get(..COVERED)?) {
            return None;
        }
        Some(Self {
            length: word(8)?,
            hardware: word(12)?,
            version: Version(word(16)?),
            replaces: Version(word(20)?),
            program_crc: word(24)?,
            key: word(28)?,
            hash: *image.get(32..)?.first_chunk()?,
            signature: *image.get(SIGNED..)?.first_chunk()?,
        })
    }

    /// Its bytes, with the CRC.
    pub fn bytes(&self) -> [u8; USED] {
        let numbers = [
            MAGIC,
            FORMAT,
            self.length,
            self.hardware,
            self.version.0,
            self.replaces.0,
            self.program_crc,
            self.key,
        ];
        let mut bytes = [0; USED];
        let content = numbers.iter().flat_map(|number| number.to_le_bytes());
        let content = content.chain(self.hash).chain(self.signature);
        for (byte, value) in bytes.iter_mut().zip(content) {
            *byte = value;
        }
        let crc = bytes
            .get(..COVERED)
            .map_or(0, |covered| CRC.checksum(covered));
        for (byte, value) in bytes.iter_mut().skip(COVERED).zip(crc.to_le_bytes()) {
            *byte = value;
        }
        bytes
    }

    /// What the signature covers.
    pub fn signed(&self) -> [u8; SIGNED] {
        let bytes = self.bytes();
        bytes.first_chunk().copied().unwrap_or([0; SIGNED])
    }

    /// The CRC of the header, which identifies the image.
    pub fn identity(&self) -> u32 {
        let bytes = self.bytes();
        bytes.last_chunk().map_or(0, |crc| u32::from_le_bytes(*crc))
    }
}
