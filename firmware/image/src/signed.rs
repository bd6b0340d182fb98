//! Signed images for the bootloader (`boot/`), and the keys for them.
//!
//! The signatures are made by `ed25519-dalek`, and the board checks them by `salty`: the tests
//! compare the two implementations.

use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};

use bootloader::layout::{Layout, STM32F427};
use bootloader::{CRC, DEVELOPMENT_SEED, HEADER_SIZE, Header, Key, Policy, Refusal, Version};
use ed25519_dalek::{Signature, Signer, SigningKey, VerifyingKey};
use sha2::{Digest, Sha512};

use crate::{ERASED, ImageError, loaded_bytes, stamp_bytes};

/// Bytes of a key, also of a private one.
const KEY_BYTES: usize = 32;

/// The most bytes of a key file: the digits, and more blanks around them than an editor adds.
const MOST_KEY_FILE: u64 = 256;

/// Why an image or a key cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum SignError {
    /// The ELF file.
    #[error(transparent)]
    Elf(#[from] ImageError),
    /// A file cannot be read or written.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A file is not a key.
    #[error(
        "{}: no key, which has 64 hexadecimal digits in a file of at most {MOST_KEY_FILE} bytes",
        path.display()
    )]
    Key {
        /// The file.
        path: PathBuf,
    },
    /// The program is not linked for the slot.
    #[error(
        "{}: the program begins at {start:#010x}, expected {expected:#010x}, the place behind the \
         header of the slot (docs/update.md)",
        path.display()
    )]
    Address {
        /// The file.
        path: PathBuf,
        /// Where it begins.
        start: u64,
        /// Where the slot's program begins.
        expected: u64,
    },
    /// A text is not a version.
    #[error("{0} is no version, expected three numbers as in 1.2.3 below 256, 4096 and 4096")]
    Version(String),
    /// The image is refused.
    #[error("{}: {}", path.display(), refusal_text(*refusal))]
    Refused {
        /// The file.
        path: PathBuf,
        /// Why.
        refusal: Refusal,
    },
    /// The system has no random numbers.
    #[error("the system has no random numbers: {0}")]
    Random(getrandom::Error),
}

/// Why an image is refused.
pub fn refusal_text(refusal: Refusal) -> &'static str {
    match refusal {
        Refusal::NoHeader => "no image, or its header is damaged",
        Refusal::Length => "its length does not fit: too long, or not all of it is there",
        Refusal::Hardware => "it is for other hardware",
        Refusal::Signature => "the signature is not of this key",
        Refusal::Program => "the program is not the one that was signed",
        Refusal::Version => "it is older than the version that runs",
    }
}

/// What an image says of its program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Description {
    /// The hardware that it is for.
    pub hardware: u32,
    /// Its version.
    pub version: Version,
    /// For a recovery image, the version that it replaces although that is later.
    pub replaces: Option<Version>,
}

/// The bytes of a signed image of this program.
pub fn sign(program: &[u8], description: &Description, key: &SigningKey) -> Vec<u8> {
    let mut program = program.to_vec();
    program.resize(program.len().next_multiple_of(4), ERASED);
    let public = Key(key.verifying_key().to_bytes());
    let mut header = Header {
        length: program.len() as u32,
        hardware: description.hardware,
        version: description.version,
        replaces: description.replaces.unwrap_or_default(),
        program_crc: CRC.checksum(&program),
        key: public.number(),
        hash: Sha512::digest(&program).into(),
        signature: [0; 64],
    };
    header.signature = key.sign(&header.signed()).to_bytes();
    let mut image = header.bytes().to_vec();
    image.resize(HEADER_SIZE as usize, ERASED);
    image.extend(program);
    image
}

/// Signs the program of an ELF file, which is linked for the slot. `elf` are the bytes that were
/// read from this file; the signed program has its CRC, the file need not.
///
/// # Errors
/// The file cannot be used.
pub fn sign_elf(
    path: &Path,
    mut elf: Vec<u8>,
    description: &Description,
    key: &SigningKey,
) -> Result<Vec<u8>, SignError> {
    stamp_bytes(path, &mut elf)?;
    let (start, program) = loaded_bytes(path, &elf)?;
    let expected = u64::from(STM32F427.slot.start() + HEADER_SIZE);
    if start != expected {
        return Err(SignError::Address {
            path: path.into(),
            start,
            expected,
        });
    }
    Ok(sign(&program, description, key))
}

/// The header of an image whose program is whole; the signature is not checked.
///
/// # Errors
/// Why it is not.
pub fn inspect(image: &[u8], layout: &Layout) -> Result<Header, Refusal> {
    let header = Header::read(image).ok_or(Refusal::NoHeader)?;
    let policy = Policy {
        hardware: header.hardware,
        floor: Version::default(),
    };
    policy.check(&header, layout.slot.size())?;
    let program = image.get(HEADER_SIZE as usize..).unwrap_or_default();
    if program.len() != header.length as usize {
        return Err(Refusal::Length);
    }
    if Sha512::digest(program).as_slice() != header.hash
        || CRC.checksum(program) != header.program_crc
    {
        return Err(Refusal::Program);
    }
    Ok(header)
}

/// As [`inspect`], and the signature is that of this key.
///
/// # Errors
/// Why it is not.
pub fn verify(image: &[u8], layout: &Layout, key: &VerifyingKey) -> Result<Header, Refusal> {
    let header = inspect(image, layout)?;
    let signature = Signature::from_bytes(&header.signature);
    key.verify_strict(&header.signed(), &signature)
        .map_err(|_| Refusal::Signature)?;
    Ok(header)
}

/// The development key, which is public.
pub fn development_key() -> SigningKey {
    SigningKey::from_bytes(&DEVELOPMENT_SEED)
}

/// Makes a key pair: the private key in `path`, which only its owner may read, and the public one
/// beside it, with `.pub` added to the name. Existing files are not overwritten.
///
/// # Errors
/// A file cannot be written.
pub fn make_key(path: &Path) -> Result<SigningKey, SignError> {
    let mut seed = [0; KEY_BYTES];
    getrandom::fill(&mut seed).map_err(SignError::Random)?;
    let key = SigningKey::from_bytes(&seed);
    write_new(path, &seed, true)?;
    write_new(&public_path(path), key.verifying_key().as_bytes(), false)?;
    Ok(key)
}

/// The file of the public key beside this private one.
pub fn public_path(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".pub");
    name.into()
}

fn write_new(path: &Path, key: &[u8; KEY_BYTES], is_private: bool) -> Result<(), SignError> {
    let mut text = String::new();
    for byte in key {
        // A string takes everything.
        let _ = write!(text, "{byte:02x}");
    }
    text.push('\n');
    let mut options = fs::OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    if is_private {
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    }
    let file = options.open(path);
    let written = file.and_then(|mut file| io::Write::write_all(&mut file, text.as_bytes()));
    written.map_err(|source| SignError::File {
        path: path.into(),
        source,
    })
}

/// Reads a private key.
///
/// # Errors
/// The file cannot be read, or holds none.
pub fn read_key(path: &Path) -> Result<SigningKey, SignError> {
    read_hex(path).map(|seed| SigningKey::from_bytes(&seed))
}

/// Reads a public key.
///
/// # Errors
/// The file cannot be read, or holds none.
pub fn read_public_key(path: &Path) -> Result<VerifyingKey, SignError> {
    let bytes = read_hex(path)?;
    VerifyingKey::from_bytes(&bytes).map_err(|_| SignError::Key { path: path.into() })
}

fn read_hex(path: &Path) -> Result<[u8; KEY_BYTES], SignError> {
    let mut text = Vec::new();
    // A longer file, such as a device without end, is not read beyond what shows that it is longer.
    let read =
        File::open(path).and_then(|file| file.take(MOST_KEY_FILE + 1).read_to_end(&mut text));
    let length = read.map_err(|source| SignError::File {
        path: path.into(),
        source,
    })?;
    let digits = text.trim_ascii();
    let mut key = [0; KEY_BYTES];
    let is_key = length as u64 <= MOST_KEY_FILE
        && digits.len() == 2 * KEY_BYTES
        && key.iter_mut().zip(digits.chunks(2)).all(|(byte, pair)| {
            let pair = std::str::from_utf8(pair).ok();
            let value = pair.and_then(|pair| u8::from_str_radix(pair, 16).ok());
            *byte = value.unwrap_or(0);
            value.is_some()
        });
    if is_key {
        Ok(key)
    } else {
        Err(SignError::Key { path: path.into() })
    }
}

#[cfg(test)]
mod tests {
    use bootloader::{ACTUATOR_BOARD, Verifier};

    use super::*;

    fn description(version: &str) -> Description {
        Description {
            hardware: ACTUATOR_BOARD,
            version: Version::parse(version).expect("a version"),
            replaces: None,
        }
    }

    #[test]
    fn the_board_accepts_the_signature_and_finds_the_same_hash() {
        let program: Vec<u8> = (0..1001_u32).map(|at| (at * 7 % 251) as u8).collect();
        for seed in 0..20 {
            let key = SigningKey::from_bytes(&[seed; 32]);
            let image = sign(&program, &description("1.2.3"), &key);
            let header = verify(&image, &STM32F427, &key.verifying_key()).expect("an image");
            let public = Key(key.verifying_key().to_bytes());
            let mut signature = header.signature;
            assert!(public.verify(header.key, &header.signed(), &signature));
            assert_eq!(
                bootloader::image_hash(&image[HEADER_SIZE as usize..]),
                header.hash
            );
            signature[40] ^= 1;
            assert!(!public.verify(header.key, &header.signed(), &signature));
        }
    }

    #[test]
    fn damaged_images_and_those_of_another_key_are_refused() {
        let key = development_key();
        let image = sign(&[1; 600], &description("0.0.1"), &key);
        let public = key.verifying_key();
        let refusal = |image: &[u8]| verify(image, &STM32F427, &public).expect_err("refused");
        let with = |at: usize| {
            let mut image = image.clone();
            image[at] ^= 1;
            image
        };
        assert_eq!(refusal(&with(0)), Refusal::NoHeader);
        assert_eq!(refusal(&with(120)), Refusal::NoHeader);
        assert_eq!(refusal(&with(700)), Refusal::Program);
        assert_eq!(refusal(&image[..800]), Refusal::Length);
        let foreign = sign(
            &[1; 600],
            &description("0.0.1"),
            &SigningKey::from_bytes(&[9; 32]),
        );
        assert_eq!(refusal(&foreign), Refusal::Signature);
    }

    #[test]
    fn a_key_is_made_once_and_read_again() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("key");
        let key = make_key(&path).expect("a key");
        assert_eq!(read_key(&path).expect("the key").to_bytes(), key.to_bytes());
        let public = read_public_key(&public_path(&path)).expect("the public key");
        assert_eq!(public, key.verifying_key());
        assert!(matches!(make_key(&path), Err(SignError::File { .. })));
        fs::write(&path, "0g").expect("written");
        assert!(matches!(read_key(&path), Err(SignError::Key { .. })));
        let padded = |blanks: usize| {
            let digits = "07".repeat(KEY_BYTES);
            fs::write(&path, digits + &" ".repeat(blanks)).expect("written");
            read_key(&path)
        };
        assert_eq!(padded(192).expect("256 bytes").to_bytes(), [7; KEY_BYTES]);
        let error = padded(193).expect_err("257 bytes").to_string();
        let expected = "no key, which has 64 hexadecimal digits in a file of at most 256 bytes";
        assert!(error.ends_with(expected), "{error}");
    }

    #[test]
    fn the_hardware_is_the_product_code_of_the_object_dictionary() {
        let entries = firmware::dictionary::DICTIONARY.entries().iter();
        let mut code = entries.filter(|entry| {
            let address = entry.address();
            (address.index, address.sub) == (0x1018, 2)
        });
        assert_eq!(
            code.next().expect("1018h:2").default_value(0),
            ACTUATOR_BOARD
        );
    }
}
