//! The interrupt handlers of the actuator board's program, from its ELF file.
//!
//! The section `.handlers` has the list that `actuator_program!` makes: interrupt, task, priority,
//! and runs in a control period. The vector table has the numbers of their exceptions, and must
//! have no other handler.

#![forbid(unsafe_code)]

use object::{Object, ObjectSection, ObjectSymbol};

/// The first vector that is one of an interrupt (DDI 0403E, B1.5.2).
const FIRST_INTERRUPT: usize = 16;

/// Time after a PWM edge within which the control step begins, us: the transfer from the encoder
/// (`docs/hardware.md`, timing of a control period).
pub const STEP_BEGINS_US: u64 = 38;

/// A handler.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Handler {
    /// Name of the interrupt, which is that of the function.
    pub interrupt: String,
    /// Name of the task.
    pub task: String,
    /// Priority of RTIC; a greater one preempts.
    pub priority: u8,
    /// How often it runs in a control period; 0 if that depends on the bus.
    pub runs: u64,
    /// Number of the exception.
    pub exception: u32,
}

/// Why the handlers are not known.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file is not an ELF program.
    #[error("not an ELF program: {0}")]
    Elf(#[from] object::Error),
    /// A line of the list has another form.
    #[error("section .handlers: {0:?}, expected `interrupt,task,priority,runs`")]
    Line(String),
    /// The vector table has other handlers than the list.
    #[error("the vector table has handlers at {found:?}, the list has those at {expected:?}")]
    Vectors {
        /// The exceptions of the table.
        found: Vec<u32>,
        /// The exceptions of the list; 0 for a handler that the table does not have.
        expected: Vec<u32>,
    },
}

/// The handlers of an ELF file of the actuator board, in the order of the list.
///
/// # Errors
/// As [`Error`] says.
pub fn handlers(elf: &[u8]) -> Result<Vec<Handler>, Error> {
    let elf = object::File::parse(elf)?;
    let section = |name| {
        let section = elf.section_by_name(name);
        section.map_or(Ok(&[][..]), |section| section.data())
    };
    let mut handlers = parse(&String::from_utf8_lossy(section(".handlers")?))?;
    let vectors: Vec<u64> = (section(".vector_table")?.as_chunks::<4>().0.iter())
        .map(|word| u64::from(u32::from_le_bytes(*word) & !1))
        .collect();
    let address = |name: &str| {
        let symbol = elf.symbols().find(|symbol| symbol.name() == Ok(name))?;
        Some(symbol.address() & !1)
    };
    let unused = [
        address("DefaultHandler"),
        address("DefaultHandler_"),
        Some(0),
    ];
    let interrupts = || (0..).zip(&vectors).skip(FIRST_INTERRUPT);
    for handler in &mut handlers {
        let own = address(&handler.interrupt);
        let vector = interrupts().find(|(_, vector)| Some(**vector) == own);
        handler.exception = vector.map_or(0, |(number, _)| number);
    }
    let used = interrupts().filter(|(_, vector)| !unused.contains(&Some(**vector)));
    let found: Vec<u32> = used.map(|(number, _)| number).collect();
    let mut expected: Vec<u32> = handlers.iter().map(|handler| handler.exception).collect();
    expected.sort_unstable();
    if found != expected {
        return Err(Error::Vectors { found, expected });
    }
    Ok(handlers)
}

/// The handlers of a list, without the numbers of their exceptions.
fn parse(list: &str) -> Result<Vec<Handler>, Error> {
    let handler = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        let &[interrupt, task, priority, runs] = &fields[..] else {
            return None;
        };
        Some(Handler {
            interrupt: interrupt.into(),
            task: task.into(),
            priority: priority.parse().ok()?,
            runs: runs.parse().ok()?,
            exception: 0,
        })
    };
    let lines = list.lines();
    lines
        .map(|line| handler(line).ok_or_else(|| Error::Line(line.into())))
        .collect()
}

/// The handlers of the control loop, which have the highest priority.
pub fn of_loop(handlers: &[Handler]) -> impl Iterator<Item = &Handler> {
    let highest = handlers.iter().map(|handler| handler.priority).max();
    let of_loop = handlers.iter();
    of_loop.filter(move |handler| Some(handler.priority) == highest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_handlers_of_the_highest_priority_are_those_of_the_loop() {
        let found = parse("TIM1,pwm_edge,4,4\nCAN1,received,3,0\nUART5,comparison,4,1\n").unwrap();
        let tasks: Vec<_> = of_loop(&found).map(|it| (&*it.task, it.runs)).collect();
        assert_eq!(tasks, [("pwm_edge", 4), ("comparison", 1)]);
        for list in ["TIM1,pwm_edge,4", "TIM1,pwm_edge,four,4"] {
            assert!(matches!(parse(list), Err(Error::Line(_))));
        }
    }
}
