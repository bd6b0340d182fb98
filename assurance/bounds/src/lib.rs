//! Bounds of stack use and execution time for all inputs, from the instructions of a program of a
//! board.
//!
//! The program has no recursion, no call by pointer and no stack frame of a variable size; each of
//! these is an [`Error`]. Its call graph and the control-flow graphs of its functions are therefore
//! exact, except that every branch is assumed possible.

mod board;
mod graph;
mod instruction;
mod loops;
mod program;
mod report;
mod routine;
mod stack;
mod time;

pub use board::{Bounds, HandlerBound};
pub use loops::LoopBounds;
pub use program::{Function, Program};
pub use stack::{InterruptLevel, StackBound, interrupt_levels, stack_bound};
pub use time::{Cost, TimeBounds};

/// Why a bound cannot be computed.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file is not an ELF program.
    #[error("not an ELF program: {0}")]
    Elf(#[from] object::Error),
    /// The disassembler failed.
    #[error("the disassembler: {0}")]
    Disassembler(#[from] capstone::Error),
    /// A function has an instruction that the analysis does not cover.
    #[error("{function} at {address:#x}: {what}")]
    Instruction {
        /// Name of the function.
        function: String,
        /// Address of the instruction.
        address: u64,
        /// What is not covered.
        what: String,
    },
    /// The program has no function of this name.
    #[error("the program has no function `{0}`")]
    NoFunction(String),
    /// Functions call each other in a circle.
    #[error("{0} calls itself, directly or by others")]
    Recursion(String),
    /// A file cannot be read.
    #[error("{0}: {1}")]
    File(String, std::io::Error),
    /// A call of a memory routine has no constant size, or one above its bound.
    #[error("{routine} is called with {found:?} bytes, the bounds of its loops permit {most}")]
    Size {
        /// Name of the routine.
        routine: &'static str,
        /// The greatest size; `None` if a size is not constant.
        found: Option<u64>,
        /// The greatest size that is permitted.
        most: u64,
    },
    /// A function has other loops than the table of bounds says.
    #[error("{function} has loops at {}, the table of bounds has {expected} of them", .found.join(", "))]
    Loops {
        /// Name of the function.
        function: String,
        /// Addresses of the loops in the program.
        found: Vec<String>,
        /// Number of bounds in the table.
        expected: usize,
    },
    /// The handlers of the program are not known.
    #[error(transparent)]
    Handlers(#[from] program_handlers::Error),
    /// A line of the table of bounds is not valid.
    #[error("line {line}: {what}")]
    Table {
        /// Number of the line, from 1.
        line: usize,
        /// What was found, and what was expected.
        what: String,
    },
}
