//! Classes of injections, finer than their [`Place`].

use std::ops::Range;

use virtual_board::run::{Firmware, FirmwareError};

use crate::injection::{Injection, Place};
use crate::motion::Motion;

/// What an injection disturbs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    /// Variables whose names contain one of [`VARIABLES`], by its place there.
    Variable(usize),
    /// The other variables.
    OtherVariables,
    /// The stack.
    Stack,
    /// The vector table.
    Vectors,
    /// The code.
    Code,
    /// The constants.
    Constants,
    /// R0 to R12.
    General,
    /// The stack pointer.
    StackPointer,
    /// The link register.
    LinkRegister,
    /// The program counter.
    ProgramCounter,
    /// The flags.
    Flags,
    /// An instruction that is skipped, in this motion.
    Instruction(Motion),
    /// Each byte of named memory, in this motion.
    Named(Motion),
}

/// Parts of the names of variables that are classes of their own, and the names of these. One that
/// the program does not have is a class without injections.
pub const VARIABLES: [(&str, &str); 5] = [
    ("CONTROL_LOOP", "RAM: both copies of the loop"),
    ("local_init_messages", "RAM: messages to the loop"),
    ("local_init_outputs", "RAM: outputs of the loop"),
    ("local_init_device", "RAM: CANopen device"),
    ("local_init_queues", "RAM: queues"),
];

impl Class {
    /// Its name in tables.
    pub fn name(self) -> String {
        let name = match self {
            Self::Variable(index) => VARIABLES[index].1,
            Self::OtherVariables => "RAM: other variables",
            Self::Stack => "RAM: stack",
            Self::Vectors => "flash: vectors",
            Self::Code => "flash: code",
            Self::Constants => "flash: constants",
            Self::General => "R0 to R12",
            Self::StackPointer => "SP",
            Self::LinkRegister => "LR",
            Self::ProgramCounter => "PC",
            Self::Flags => "flags",
            Self::Instruction(motion) => return format!("skipped: {}", motion.name()),
            Self::Named(motion) => return format!("each byte: {}", motion.name()),
        };
        name.into()
    }

    /// The class of a register by its number.
    fn of_register(number: u64) -> Self {
        match number {
            0..=12 => Self::General,
            13 => Self::StackPointer,
            14 => Self::LinkRegister,
            15 => Self::ProgramCounter,
            _ => Self::Flags,
        }
    }
}

/// Where the parts of a program lie in the memory.
#[derive(Debug, Clone)]
pub struct MemoryMap {
    parts: Vec<(Range<u64>, Class)>,
}

impl MemoryMap {
    /// The memory of this program.
    ///
    /// # Errors
    /// The ELF file lacks a symbol.
    pub fn try_new(firmware: &Firmware) -> Result<Self, FirmwareError> {
        let stack = firmware.address("_stack_end")?..firmware.address("_stack_start")?;
        let mut parts = vec![(stack, Class::Stack)];
        for (index, (text, _)) in VARIABLES.iter().enumerate() {
            let ranges = firmware.variables_containing(text);
            parts.extend(ranges.map(|range| (range, Class::Variable(index))));
        }
        let sections = [
            (".vector_table", Class::Vectors),
            (".text", Class::Code),
            (".rodata", Class::Constants),
        ];
        parts.extend(sections.map(|(name, class)| (firmware.section(name), class)));
        Ok(Self { parts })
    }

    /// The class of an injection.
    pub fn class(&self, injection: &Injection) -> Class {
        match injection.place {
            Place::Registers => Class::of_register(injection.address / 4),
            Place::Instruction => Class::Instruction(injection.motion),
            Place::Named => Class::Named(injection.motion),
            Place::Ram | Place::Code => {
                let mut parts = self.parts.iter();
                let part = parts.find(|(range, _)| range.contains(&injection.address));
                part.map_or(Class::OtherVariables, |(_, class)| *class)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use board_tests::program::firmware;

    use super::*;

    fn classes(place: Place) -> BTreeSet<Class> {
        let firmware = firmware();
        let map = MemoryMap::try_new(firmware).unwrap();
        let ranges = place.ranges(firmware).unwrap();
        let draw = |number| map.class(&Injection::draw(1, number, place, &ranges));
        (0..20_000).map(draw).collect()
    }

    #[test]
    fn every_part_of_the_memory_and_every_register_has_its_class() {
        use Class::*;
        let memory = (0..VARIABLES.len()).map(Variable);
        let memory: BTreeSet<Class> = memory.chain([OtherVariables, Stack]).collect();
        assert_eq!(classes(Place::Ram), memory);
        assert_eq!(classes(Place::Code), [Vectors, Code, Constants].into());
        let registers = [General, StackPointer, LinkRegister, ProgramCounter, Flags];
        assert_eq!(classes(Place::Registers), registers.into());
        let motions = Motion::ALL.map(Class::Instruction);
        assert_eq!(classes(Place::Instruction), motions.into());
    }
}
