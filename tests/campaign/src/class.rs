//! Classes of injections, finer than their [`Place`].

use std::ops::Range;

use virtual_board::run::{Firmware, FirmwareError};

use crate::injection::{Injection, Place};
use crate::motion::Motion;

/// What an injection disturbs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    /// The CANopen device: parameters, object values, and the state of axis and loop.
    Device,
    /// Its copy, from which a control step is computed a second time.
    Copy,
    /// The queues between the tasks.
    Queues,
    /// The other variables: drivers, counters, the background task.
    Variables,
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
    /// Each instruction of a control period, which is skipped once, in this motion.
    Period(Motion),
}

impl Class {
    /// Its name in tables and pictures.
    pub fn name(self) -> String {
        let name = match self {
            Self::Device => "RAM: CANopen device",
            Self::Copy => "RAM: copy of the device",
            Self::Queues => "RAM: queues",
            Self::Variables => "RAM: other variables",
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
            Self::Period(motion) => return format!("each skipped: {}", motion.name()),
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
        let mut parts = vec![
            (firmware.symbol_containing("copy_of_device")?, Class::Copy),
            (
                firmware.symbol_containing("local_init_device")?,
                Class::Device,
            ),
            (stack, Class::Stack),
        ];
        let queues = firmware.variables_containing("task_queues");
        parts.extend(queues.map(|range| (range, Class::Queues)));
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
            Place::Period => Class::Period(injection.motion),
            Place::Ram | Place::Code => {
                let mut parts = self.parts.iter();
                let part = parts.find(|(range, _)| range.contains(&injection.address));
                part.map_or(Class::Variables, |(_, class)| *class)
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
        let memory = [Device, Copy, Queues, Variables, Stack];
        assert_eq!(classes(Place::Ram), memory.into());
        assert_eq!(classes(Place::Code), [Vectors, Code, Constants].into());
        let registers = [General, StackPointer, LinkRegister, ProgramCounter, Flags];
        assert_eq!(classes(Place::Registers), registers.into());
        let motions = Motion::ALL.map(Class::Instruction);
        assert_eq!(classes(Place::Instruction), motions.into());
    }
}
