//! The ELF file: image, symbols, and the return instructions of functions.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use object::{Object, ObjectSection, ObjectSymbol, SymbolKind};
use rigless::image::Image;

use crate::board::ChipKind;
use crate::flash::BASE;

/// Why an ELF file cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum FirmwareError {
    /// It cannot be read.
    #[error("{path}: {message}", path = path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        message: String,
    },
    /// It is not the program that is expected.
    #[error("{path} {is}; expected the program {expected}", path = path.display())]
    OtherProgram {
        /// The file.
        path: PathBuf,
        /// What is expected.
        expected: &'static str,
        /// What it is.
        is: String,
    },
    /// It lacks a symbol.
    #[error("{path} has no symbol {name}", path = path.display())]
    NoSymbol {
        /// The file.
        path: PathBuf,
        /// The name.
        name: String,
    },
}

/// Initial contents of the memory from an address on.
pub(super) fn contents(address: u64, bytes: Vec<u8>) -> Result<Image, rigless::emulator::Error> {
    let name = format!("contents of {address:#x}");
    Ok(Image::new(Path::new(&name), bytes, Some(address))?)
}

/// A function of the firmware.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Function {
    pub entry: u64,
    /// Addresses of the instructions that return from it.
    pub exits: Vec<u64>,
}

#[derive(Debug, Clone)]
struct Symbol {
    address: u64,
    size: u64,
    is_code: bool,
}

/// A firmware.
#[derive(Debug, Clone)]
pub struct Firmware {
    path: PathBuf,
    bytes: Vec<u8>,
    symbols: BTreeMap<String, Symbol>,
}

/// A handler of the program: a line of its section `.handlers`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Handler {
    /// The interrupt, whose symbol is that of the handler.
    pub interrupt: String,
    /// The task.
    pub task: String,
    /// Its priority; a higher number preempts a lower one.
    pub priority: u8,
    /// Runs in a control period; 0 for a handler that depends on the bus.
    pub runs: u64,
}

impl Handler {
    fn parse(line: &str) -> Option<Self> {
        let fields: Vec<&str> = line.split(',').collect();
        let [interrupt, task, priority, runs] = fields.try_into().ok()?;
        Some(Self {
            interrupt: interrupt.into(),
            task: task.into(),
            priority: priority.parse().ok()?,
            runs: runs.parse().ok()?,
        })
    }
}

impl Firmware {
    /// Reads an ELF file.
    ///
    /// # Errors
    /// The file cannot be read, or is not an ELF file.
    pub fn read(path: &Path) -> Result<Self, FirmwareError> {
        let bytes = std::fs::read(path).map_err(|error| unreadable(path, &error))?;
        Self::of(path, bytes)
    }

    /// An ELF file that has been read from this path.
    ///
    /// # Errors
    /// It is not an ELF file.
    pub fn of(path: &Path, bytes: Vec<u8>) -> Result<Self, FirmwareError> {
        let file = object::File::parse(&*bytes).map_err(|error| unreadable(path, &error))?;
        let symbols = file.symbols().filter_map(|symbol| {
            let is_code = symbol.kind() == SymbolKind::Text;
            let name = symbol.name().ok().filter(|name| !name.is_empty())?;
            let entry = Symbol {
                // The lowest bit of a function's address marks Thumb code.
                address: symbol.address() & !u64::from(is_code),
                size: symbol.size(),
                is_code,
            };
            Some((name.to_owned(), entry))
        });
        Ok(Self {
            path: path.into(),
            symbols: symbols.collect(),
            bytes,
        })
    }

    pub(super) fn image(&self) -> Result<Image, rigless::emulator::Error> {
        Ok(Image::new(&self.path, self.bytes.clone(), None)?)
    }

    fn no_symbol(&self, name: &str) -> FirmwareError {
        FirmwareError::NoSymbol {
            path: self.path.clone(),
            name: name.into(),
        }
    }

    /// Address of a symbol.
    ///
    /// # Errors
    /// The file has no symbol of this name.
    pub fn address(&self, name: &str) -> Result<u64, FirmwareError> {
        let symbol = self.symbols.get(name).ok_or_else(|| self.no_symbol(name))?;
        Ok(symbol.address)
    }

    /// Addresses of a section; empty if the file does not have it.
    pub fn section(&self, name: &str) -> Range<u64> {
        let file = object::File::parse(&*self.bytes).ok();
        let section = file.as_ref().and_then(|file| file.section_by_name(name));
        section.map_or(0..0, |section| {
            section.address()..section.address() + section.size()
        })
    }

    /// The handlers that the program lists.
    ///
    /// # Errors
    /// The file has no list, or one that cannot be read.
    pub fn handlers(&self) -> Result<Vec<Handler>, FirmwareError> {
        let lines = self.text(".handlers");
        let handlers = lines.and_then(|lines| lines.lines().map(Handler::parse).collect());
        handlers.ok_or_else(|| self.no_symbol(".handlers"))
    }

    /// The chip that an actuator board's program is for.
    ///
    /// # Errors
    /// It is another program, or states nothing.
    pub fn actuator_chip(&self) -> Result<ChipKind, FirmwareError> {
        let kinds = [(ChipKind::F427, "STM32F427"), (ChipKind::H743, "STM32H743")];
        let is = self.text(".board").unwrap_or_default();
        let chip = is.strip_prefix("actuator board, ");
        let kind = kinds.iter().find(|(_, name)| chip == Some(name));
        let (kind, _) = kind.ok_or_else(|| self.no_program("of an actuator board", is))?;
        Ok(*kind)
    }

    /// Whether this is the communication board's program.
    ///
    /// # Errors
    /// It is another program, or states nothing.
    pub fn check_comm_board(&self) -> Result<(), FirmwareError> {
        match self.text(".board").unwrap_or_default() {
            is if is == "communication board, STM32F427" => Ok(()),
            is => Err(self.no_program("of the communication board", is)),
        }
    }

    fn no_program(&self, expected: &'static str, is: String) -> FirmwareError {
        FirmwareError::OtherProgram {
            path: self.path.clone(),
            expected,
            is: match is.is_empty() {
                true => "states no board".into(),
                false => format!("is the program of: {is}"),
            },
        }
    }

    /// The text of a section.
    fn text(&self, section: &str) -> Option<String> {
        let file = object::File::parse(&*self.bytes).ok()?;
        let section = file.section_by_name(section)?;
        String::from_utf8(section.data().ok()?.into()).ok()
    }

    /// Address of the vector table, if it is not at the start of the flash.
    pub(super) fn vector_table(&self) -> Option<u32> {
        let table = self.section(".vector_table").start;
        (table > BASE)
            .then_some(table)
            .and_then(|table| u32::try_from(table).ok())
    }

    /// Addresses of the first variable whose name contains this text, such as one whose full name
    /// the compiler makes.
    ///
    /// # Errors
    /// The file has no such variable.
    pub fn symbol_containing(&self, text: &str) -> Result<Range<u64>, FirmwareError> {
        let found = self.variables_containing(text).next();
        found.ok_or_else(|| self.no_symbol(text))
    }

    /// Addresses of all variables whose names contain this text.
    pub fn variables_containing(&self, text: &str) -> impl Iterator<Item = Range<u64>> {
        let symbols = self.symbols.iter();
        let found = symbols.filter(move |(name, symbol)| !symbol.is_code && name.contains(text));
        found.map(|(_, symbol)| symbol.address..symbol.address + symbol.size)
    }

    /// Names of all functions.
    pub fn functions(&self) -> impl Iterator<Item = &str> {
        let functions = self.symbols.iter().filter(|(_, symbol)| symbol.is_code);
        functions.map(|(name, _)| name.as_str())
    }

    pub(super) fn function(&self, name: &str) -> Result<Function, FirmwareError> {
        let symbol = self.symbols.get(name).filter(|symbol| symbol.is_code);
        let symbol = symbol.ok_or_else(|| self.no_symbol(name))?;
        let code = self.code(symbol).ok_or_else(|| self.no_symbol(name))?;
        Ok(Function {
            entry: symbol.address,
            exits: returns(code, symbol.address),
        })
    }

    fn code(&self, symbol: &Symbol) -> Option<&[u8]> {
        let file = object::File::parse(&*self.bytes).ok()?;
        let section = file.sections().find(|section| {
            (section.address()..section.address() + section.size()).contains(&symbol.address)
        })?;
        let (offset, _) = section.file_range()?;
        let start = (offset + symbol.address - section.address()) as usize;
        self.bytes.get(start..start + symbol.size as usize)
    }
}

fn unreadable(path: &Path, error: &dyn std::error::Error) -> FirmwareError {
    FirmwareError::Unreadable {
        path: path.into(),
        message: error.to_string(),
    }
}

/// Addresses of the instructions that leave a function, in Thumb code: `bx lr`, `pop {.., pc}`,
/// `ldmia sp!, {.., pc}`, `ldr pc, [sp], #..`, and a jump out of the function, which is a tail call
/// or a shared epilogue.
fn returns(code: &[u8], address: u64) -> Vec<u64> {
    let half = |at: usize| Some(u16::from_le_bytes([*code.get(at)?, *code.get(at + 1)?]));
    let end = address + code.len() as u64;
    let mut exits = Vec::new();
    let mut at = 0;
    while let Some(first) = half(at) {
        let second = half(at + 2).unwrap_or(0);
        let is_wide = first >> 11 >= 0b11101;
        let here = address + at as u64;
        let jumps_out = jump(first, second)
            .map(|offset| here.wrapping_add_signed(4 + offset))
            .is_some_and(|target| !(address..end).contains(&target));
        let leaves = match first {
            0x4770 => true,
            0xe8bd => second >> 15 == 1,
            0xf85d => second >> 12 == 0xf,
            narrow => narrow >> 8 == 0xbd,
        };
        if leaves || jumps_out {
            exits.push(here);
        }
        at += if is_wide { 4 } else { 2 };
    }
    exits
}

/// Offset of an unconditional jump (DDI 0403E, A7.7.12, encodings T2 and T4).
fn jump(first: u16, second: u16) -> Option<i64> {
    let bits = |word: u16, low: u32, count: u32| i64::from(word >> low) & ((1 << count) - 1);
    if first >> 11 == 0b11100 {
        return Some(bits(first, 0, 11) << 53 >> 52);
    }
    if first >> 11 != 0b11110 || second & 0xd000 != 0x9000 {
        return None;
    }
    let sign = bits(first, 10, 1);
    let from = |j: i64| 1 - (j ^ sign);
    let high = sign << 24 | from(bits(second, 13, 1)) << 23 | from(bits(second, 11, 1)) << 22;
    let offset = high | bits(first, 0, 10) << 12 | bits(second, 0, 11) << 1;
    Some(offset << 39 >> 39)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn returns_are_found_between_narrow_and_wide_instructions() {
        let halves: [u16; 8] = [
            0xb510, // push {r4, lr}
            0xf240, 0x4770, // movw: its second half looks like bx lr
            0xbd10, // pop {r4, pc}
            0xe8bd, 0x87f0, // pop.w {r4-r10, pc}
            0xbf00, // nop
            0x4770, // bx lr
        ];
        let code: Vec<u8> = halves.iter().flat_map(|half| half.to_le_bytes()).collect();
        assert_eq!(returns(&code, 0x100), [0x106, 0x108, 0x10e]);
    }

    #[test]
    fn a_jump_out_of_the_function_ends_it_and_one_within_does_not() {
        let halves: [u16; 4] = [
            0xe7fe, // b.n to itself
            0xf007, 0xbf7c, // b.w +0x7ef8, as 8000071a jumps to 8008616
            0xe001, // b.n beyond the end
        ];
        let code: Vec<u8> = halves.iter().flat_map(|half| half.to_le_bytes()).collect();
        assert_eq!(jump(0xf007, 0xbf7c), Some(0x0800_8616 - 0x0800_071a - 4));
        assert_eq!(jump(0xe7fe, 0), Some(-4));
        assert_eq!(returns(&code, 0x0800_0004 - 2), [0x0800_0004, 0x0800_0008]);
    }

    #[test]
    fn the_error_names_a_missing_file() {
        let error = Firmware::read(Path::new("no/such.elf"))
            .unwrap_err()
            .to_string();
        assert!(error.starts_with("no/such.elf: "), "{error}");
    }
}
