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

use std::path::{Path, PathBuf};
use std::{fs, io};

use firmware::integrity::program_crc;
use object::elf::FileHeader32;
use object::endian::LittleEndian;
use object::read::elf::{ElfFile, ProgramHeader};
use object::{Object, ObjectSection, ObjectSegment, ObjectSymbol};

/// Content of flash that is not programmed.
const ERASED: u8 = 0xff;

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
    let elf_error = |source| ImageError::Elf {
        path: path.into(),
        source,
    };
    let file = Elf::parse(bytes).map_err(elf_error)?;
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
    let program = bytes_between(&file, start, end).map_err(elf_error)?;
    Ok(Some((offset as usize, program_crc(&program))))
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
    let elf_error = |source| ImageError::Elf {
        path: path.into(),
        source,
    };
    let file = Elf::parse(bytes).map_err(elf_error)?;
    let loads = file.segments().map(|segment| {
        let header = segment.elf_program_header();
        let (load, size) = (header.p_paddr(LittleEndian), header.p_filesz(LittleEndian));
        (u64::from(load), u64::from(size))
    });
    let loads: Vec<_> = loads.filter(|(_, size)| *size > 0).collect();
    let start = loads.iter().map(|(load, _)| *load).min().unwrap_or(0);
    let end = loads.iter().map(|(load, size)| load + size).max();
    let bytes = bytes_between(&file, start, end.unwrap_or(0)).map_err(elf_error)?;
    Ok((start, bytes))
}

type Elf<'a> = ElfFile<'a, FileHeader32<LittleEndian>>;

/// What the segments of a file load between two addresses; the rest is erased.
fn bytes_between(file: &Elf<'_>, start: u64, end: u64) -> Result<Vec<u8>, object::Error> {
    let mut bytes = vec![ERASED; end.saturating_sub(start) as usize];
    for segment in file.segments() {
        let load = u64::from(segment.elf_program_header().p_paddr(LittleEndian));
        let data = segment.data()?;
        let Some(begin) = load.checked_sub(start).map(|begin| begin as usize) else {
            continue;
        };
        for (to, from) in bytes.iter_mut().skip(begin).zip(data) {
            *to = *from;
        }
    }
    Ok(bytes)
}
