//! What is disturbed, where, and when.

use std::iter;
use std::ops::Range;

use rand_pcg::{Pcg32, rand_core::Rng};
use serde::{Deserialize, Serialize};
use virtual_board::run::{Firmware, FirmwareError};

use crate::motion::Motion;

/// Bytes of the stack below its highest address that the program uses (`tests/board` holds the
/// deepest use of a run).
const STACK_BYTES: u64 = 3 << 10;

/// R0 to R15 and the program status.
const REGISTERS: u64 = 17;

/// Instants of the injections, ms after power-on: the drive is enabled and moves.
const INSTANTS_MS: Range<u32> = 300..LATEST_MS;

/// End of these instants, ms.
pub const LATEST_MS: u32 = 1500;

/// Instructions in three control periods of a moving drive, about: an injection into the core
/// follows its instant after up to so many, so that it meets an instruction as often as that is
/// executed.
const INSTRUCTIONS: u32 = 130_000;

/// Where an injection is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Place {
    /// A bit of variables or of the part of the stack that is used.
    Ram,
    /// A bit of vectors, code or constants in the flash.
    Code,
    /// A bit of R0 to R15 or of the flags.
    Registers,
    /// An instruction, which is skipped.
    Instruction,
    /// Each byte of memory that is named, of which one bit is inverted.
    Named,
}

impl Place {
    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ram => "RAM: variables and used stack",
            Self::Code => "flash: vectors, code, constants",
            Self::Registers => "R0 to R15 and flags",
            Self::Instruction => "a skipped instruction",
            Self::Named => "each byte of named memory",
        }
    }

    /// Its address ranges in this program, of which injections are drawn; of the registers, four
    /// bytes each. The capture buffer is not a part: it is a recording.
    ///
    /// # Errors
    /// The ELF file lacks a symbol.
    pub fn ranges(self, firmware: &Firmware) -> Result<Vec<Range<u64>>, FirmwareError> {
        let sections = |names: &[&str]| -> Vec<Range<u64>> {
            names.iter().map(|name| firmware.section(name)).collect()
        };
        Ok(match self {
            Self::Registers => iter::once(0..4 * REGISTERS).collect(),
            Self::Instruction | Self::Named => iter::once(0..1).collect(),
            Self::Code => sections(&[".vector_table", ".text", ".rodata"]),
            Self::Ram => {
                let stack_end = firmware.address("_stack_start")?;
                let mut ranges = variables(firmware)?;
                ranges.push(stack_end - STACK_BYTES..stack_end);
                ranges
            }
        })
    }
}

/// The variables without the capture buffer.
fn variables(firmware: &Firmware) -> Result<Vec<Range<u64>>, FirmwareError> {
    let capture = firmware.symbol_containing("capture_buffer")?;
    let names = [".data", ".bss", ".uninit", ".core_memory"];
    let sections = names.map(|name| firmware.section(name));
    let without = |range: &Range<u64>| {
        [
            range.start..range.end.min(capture.start),
            range.start.max(capture.end)..range.end,
        ]
    };
    let parts = sections.iter().flat_map(without);
    Ok(parts.filter(|part| part.start < part.end).collect())
}

/// An injection, and the motion that it disturbs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Injection {
    /// Number of the experiment.
    pub number: u64,
    /// Where.
    pub place: Place,
    /// Address of the byte; of a register, four times its number and the byte in it.
    pub address: u64,
    /// The bit, 0 to 7.
    pub bit: u8,
    /// Instant after power-on, ms.
    pub at_ms: u32,
    /// Instructions of the core after that instant, for an injection into the core.
    pub instructions: u32,
    /// The motion.
    pub motion: Motion,
}

impl Injection {
    /// The injection of this number of the campaign with this seed, uniform over all bits of the
    /// ranges.
    ///
    /// # Panics
    /// If the ranges are empty.
    pub fn draw(seed: u64, number: u64, place: Place, ranges: &[Range<u64>]) -> Self {
        // The streams of the places differ.
        let mut random = Pcg32::new(seed, number << 3 | place as u64);
        let address = pick(ranges, random.next_u32()).expect("the place has bits");
        Self::at(address, number, place, &mut random)
    }

    /// The flip in the byte at this address.
    pub fn of_byte(seed: u64, address: u64) -> Self {
        let mut random = Pcg32::new(seed, address << 3 | Place::Named as u64);
        Self::at(address, address, Place::Named, &mut random)
    }

    fn at(address: u64, number: u64, place: Place, random: &mut Pcg32) -> Self {
        let mut below =
            |limit: u32| ((u64::from(random.next_u32()) * u64::from(limit)) >> 32) as u32;
        Self {
            number,
            place,
            address,
            bit: below(8) as u8,
            at_ms: INSTANTS_MS.start + below(INSTANTS_MS.end - INSTANTS_MS.start),
            motion: Motion::ALL[below(Motion::ALL.len() as u32) as usize],
            instructions: below(INSTRUCTIONS),
        }
    }

    /// Time from its millisecond to an injection into memory, ns: within the period, at an instant
    /// that does not depend on the PWM.
    pub fn phase_ns(&self) -> u64 {
        self.number * 7_919 % 1000 * 1000
    }
}

/// The address in these ranges that a random number selects.
fn pick(ranges: &[Range<u64>], random: u32) -> Option<u64> {
    let bytes: u64 = ranges.iter().map(|range| range.end - range.start).sum();
    let mut offset = u64::from(random).checked_rem(bytes)?;
    for range in ranges {
        let length = range.end - range.start;
        if offset < length {
            return Some(range.start + offset);
        }
        offset -= length;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flips_repeat_by_seed_and_number_and_reach_every_range() {
        let ranges = [0x100..0x110, 0x800..0x810];
        let draw = |number| Injection::draw(7, number, Place::Ram, &ranges);
        let injections: Vec<Injection> = (0..100).map(draw).collect();
        assert_eq!(injections, (0..100).map(draw).collect::<Vec<_>>());
        for range in &ranges {
            let within = injections
                .iter()
                .filter(|injection| range.contains(&injection.address));
            // 50 of 100 are expected; 25 are five standard deviations less.
            assert!(within.count() > 25);
        }
    }

    #[test]
    fn each_byte_is_flipped_once_at_an_instant_that_the_seed_decides() {
        let all = |seed| crate::campaign::draw_each(seed, &[0x100..0x104, 0x800..0x804]);
        let addresses: Vec<u64> = all(1).iter().map(|it| it.address).collect();
        assert_eq!(
            addresses,
            [0x100, 0x101, 0x102, 0x103, 0x800, 0x801, 0x802, 0x803]
        );
        assert_eq!(all(1), all(1));
        assert_ne!(all(1), all(2));
    }
}
