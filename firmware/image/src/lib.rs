//! Writes the CRC of a board's program into its ELF file, and makes signed images of it
//! ([`signed`]).
//!
//! The program checks its flash against this CRC (`firmware::integrity`). A linker cannot compute
//! it, so it is written into the section `.program_crc` after linking. The CRC covers the flash
//! from `_program_start` to `_program_crc`, with erased bytes between the sections.

#![forbid(unsafe_code)]
#![deny(missing_docs)]

pub mod flashing;
pub mod signed;

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::{fs, io};

use firmware::integrity::program_crc;
use object::elf::FileHeader32;
use object::endian::LittleEndian;
use object::read::elf::{ElfFile, ProgramHeader};
use object::{Object, ObjectSection, ObjectSegment, ObjectSymbol};

/// Content of flash that is not programmed.
const ERASED: u8 = 0xff;

/// Bytes of the flash memory of both chips (RM0090, section 3.3; RM0433, section 4.3.4): a program
/// that spans more is not one of a board.
const MOST_FLASH: u64 = 2 << 20;

/// Section of the CRC.
const SECTION: &str = ".program_crc";

/// Why a file was not changed.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// It cannot be read or written.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// It is not an ELF file of 32 bits, or a segment is outside the file.
    #[error("{}: {source}", path.display())]
    Elf {
        /// The file.
        path: PathBuf,
        /// Why.
        source: object::Error,
    },
    /// It spans more than the flash memory.
    #[error("{}: spans {bytes} bytes of memory, expected at most {MOST_FLASH}", path.display())]
    TooLong {
        /// The file.
        path: PathBuf,
        /// From the first byte to the last one.
        bytes: u64,
    },
    /// It lacks a symbol of `memory.x`.
    #[error("{}: no symbol {name}; the program is not linked with memory.x", path.display())]
    NoSymbol {
        /// The file.
        path: PathBuf,
        /// The symbol.
        name: &'static str,
    },
}

/// Writes the CRC into this file, if it has a section for it; returns the CRC.
///
/// # Errors
/// The file is not a program of a board, or cannot be read or written.
pub fn stamp(path: &Path) -> Result<Option<u32>, ImageError> {
    let before = read(path)?;
    let mut bytes = before.clone();
    let crc = stamp_bytes(path, &mut bytes)?;
    // Unchanged files keep their time, on which builds depend.
    if bytes != before {
        fs::write(path, &bytes).map_err(|source| ImageError::File {
            path: path.into(),
            source,
        })?;
    }
    Ok(crc)
}

/// Writes the CRC into the bytes of this file, if it has a section for it; returns the CRC.
fn stamp_bytes(path: &Path, bytes: &mut [u8]) -> Result<Option<u32>, ImageError> {
    let Some((offset, crc)) = place_and_crc(path, bytes)? else {
        return Ok(None);
    };
    if let Some(word) = bytes.get_mut(offset..offset + 4) {
        word.copy_from_slice(&crc.to_le_bytes());
    }
    Ok(Some(crc))
}

fn read(path: &Path) -> Result<Vec<u8>, ImageError> {
    fs::read(path).map_err(|source| ImageError::File {
        path: path.into(),
        source,
    })
}

/// Offset of the CRC in the file, and its value.
fn place_and_crc(path: &Path, bytes: &[u8]) -> Result<Option<(usize, u32)>, ImageError> {
    let file = parse(path, bytes)?;
    let section = file
        .section_by_name(SECTION)
        .filter(|section| section.size() == 4);
    let Some((offset, _)) = section.and_then(|section| section.file_range()) else {
        return Ok(None);
    };
    let address = |name| {
        let symbol = file.symbol_by_name(name).map(|symbol| symbol.address());
        symbol.ok_or_else(|| ImageError::NoSymbol {
            path: path.into(),
            name,
        })
    };
    let (start, end) = (address("_program_start")?, address("_program_crc")?);
    let program = bytes_between(path, &file, start..end)?;
    let (words, _) = program.as_chunks();
    let words: Vec<u32> = words.iter().copied().map(u32::from_le_bytes).collect();
    Ok(Some((offset as usize, program_crc(&words))))
}

/// The bytes that the file loads into the flash memory, from the first one to the last one; gaps
/// are erased.
///
/// # Errors
/// The file is not a program of a board, or cannot be read.
pub fn flash(path: &Path) -> Result<Vec<u8>, ImageError> {
    loaded(path).map(|(_, bytes)| bytes)
}

/// As [`flash`], with the address of the first byte.
///
/// # Errors
/// As [`flash`].
pub fn loaded(path: &Path) -> Result<(u64, Vec<u8>), ImageError> {
    loaded_bytes(path, &read(path)?)
}

/// As [`loaded`], of the bytes of this file.
fn loaded_bytes(path: &Path, bytes: &[u8]) -> Result<(u64, Vec<u8>), ImageError> {
    let file = parse(path, bytes)?;
    let loads = file.segments().map(|segment| {
        let header = segment.elf_program_header();
        let (load, size) = (header.p_paddr(LittleEndian), header.p_filesz(LittleEndian));
        (u64::from(load), u64::from(size))
    });
    let loads: Vec<_> = loads.filter(|(_, size)| *size > 0).collect();
    let start = loads.iter().map(|(load, _)| *load).min().unwrap_or(0);
    let end = loads.iter().map(|(load, size)| load + size).max();
    let bytes = bytes_between(path, &file, start..end.unwrap_or(0))?;
    Ok((start, bytes))
}

type Elf<'a> = ElfFile<'a, FileHeader32<LittleEndian>>;

fn parse<'a>(path: &Path, bytes: &'a [u8]) -> Result<Elf<'a>, ImageError> {
    Elf::parse(bytes).map_err(|source| ImageError::Elf {
        path: path.into(),
        source,
    })
}

/// What the segments of a file load between two addresses; the rest is erased.
fn bytes_between(path: &Path, file: &Elf<'_>, span: Range<u64>) -> Result<Vec<u8>, ImageError> {
    let path = || path.into();
    let bytes = span.end.saturating_sub(span.start);
    if bytes > MOST_FLASH {
        return Err(ImageError::TooLong {
            path: path(),
            bytes,
        });
    }
    let mut bytes = vec![ERASED; bytes as usize];
    for segment in file.segments() {
        let load = u64::from(segment.elf_program_header().p_paddr(LittleEndian));
        let data = segment.data().map_err(|source| ImageError::Elf {
            path: path(),
            source,
        })?;
        let Some(begin) = load.checked_sub(span.start).map(|begin| begin as usize) else {
            continue;
        };
        for (to, from) in bytes.iter_mut().skip(begin).zip(data) {
            *to = *from;
        }
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An ELF file of 32 bits that loads four bytes to each of these addresses.
    fn elf(addresses: [u32; 2]) -> Vec<u8> {
        let headers = 52;
        // Executable, Arm, version 1.
        let mut bytes = b"\x7fELF\x01\x01\x01\0\0\0\0\0\0\0\0\0\x02\0\x28\0\x01\0\0\0".to_vec();
        let words = |bytes: &mut Vec<u8>, words: &[u32]| {
            bytes.extend(words.iter().flat_map(|word| word.to_le_bytes()));
        };
        // No entry, the program headers, no sections, no flags.
        words(&mut bytes, &[0, headers, 0, 0]);
        // Sizes and numbers of the headers: 52, 32, 2, 40, 0, 0.
        words(&mut bytes, &[52 | 32 << 16, 2 | 40 << 16, 0]);
        for address in addresses {
            words(&mut bytes, &[1, 0, address, address, 4, 4, 0, 4]);
        }
        bytes
    }

    #[test]
    fn an_elf_file_that_spans_more_than_the_flash_is_refused() {
        let span = |last| loaded_bytes(Path::new("a.elf"), &elf([0x0800_0000, last]));
        let (start, bytes) = span(0x0800_0010).expect("a program");
        assert_eq!((start, bytes.len()), (0x0800_0000, 0x14));
        assert_eq!(span(0x081f_fffc).expect("the whole flash").1.len(), 2 << 20);
        let error = span(0xffff_fff0).expect_err("too long").to_string();
        assert_eq!(
            error,
            "a.elf: spans 4160749556 bytes of memory, expected at most 2097152"
        );
    }
}
