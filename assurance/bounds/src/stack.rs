//! Worst-case stack use from the call graph.

use std::collections::{BTreeMap, BTreeSet};

use program_handlers::Handler;

use crate::Error;
use crate::program::{Function, Program};

/// Bytes of an exception's stack frame with floating-point registers, and the word that aligns it
/// (Armv7-M Architecture Reference Manual, section B1.5.7).
pub const EXCEPTION_FRAME: u64 = 0x68 + 4;

/// Interrupts of one priority: one of them runs at a time.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InterruptLevel {
    /// Priority of RTIC; a greater one preempts.
    pub priority: u8,
    /// Names of the handlers.
    pub handlers: Vec<String>,
}

/// The levels of these handlers, lowest first.
pub fn interrupt_levels(handlers: &[Handler]) -> Vec<InterruptLevel> {
    let mut levels = BTreeMap::<u8, Vec<String>>::new();
    for handler in handlers {
        let level = levels.entry(handler.priority).or_default();
        level.push(handler.interrupt.clone());
    }
    let levels = levels.into_iter();
    levels
        .map(|(priority, handlers)| InterruptLevel { priority, handlers })
        .collect()
}

/// Worst-case stack use, bytes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StackBound {
    /// From the reset to the end of the initialisation, in which no interrupt is enabled.
    pub initialisation: u64,
    /// What remains of it while the program idles.
    pub idle: u64,
    /// For each level of interrupts the handler with the greatest use, and that use with the
    /// exception frame.
    pub levels: Vec<(String, u64)>,
    /// The handler of a fault with the greatest use, with the exception frame: it can preempt every
    /// other one.
    pub fault: (String, u64),
}

impl StackBound {
    /// The bound for everything together.
    pub fn total(&self) -> u64 {
        let nested: u64 = self.levels.iter().map(|(_, bytes)| bytes).sum();
        (self.idle + nested).max(self.initialisation) + self.fault.1
    }
}

/// Bytes of a function's own frame. All of its changes of the stack pointer count, as if none were
/// undone before the next one.
fn frame(function: &Function) -> u64 {
    let instructions = function.instructions.values();
    instructions.map(|(instruction, _)| instruction.stack).sum()
}

/// Worst-case use of a function with everything that it calls.
fn depth(
    program: &Program,
    function: &Function,
    path: &mut BTreeSet<u64>,
    known: &mut BTreeMap<u64, u64>,
) -> Result<u64, Error> {
    if let Some(depth) = known.get(&function.address) {
        return Ok(*depth);
    }
    if !path.insert(function.address) {
        return Err(Error::Recursion(function.name.clone()));
    }
    let mut deepest = 0;
    for (_, callee) in &function.calls {
        deepest = deepest.max(depth(program, program.at(*callee)?, path, known)?);
    }
    path.remove(&function.address);
    let depth = frame(function) + deepest;
    known.insert(function.address, depth);
    Ok(depth)
}

/// The bound of a program: its functions from the reset to the idle loop, the outermost first; its
/// levels of interrupts; and the handlers of its faults.
///
/// # Errors
/// If a function is missing, or functions call each other in a circle.
pub fn stack_bound(
    program: &Program,
    start: &[&str],
    levels: &[InterruptLevel],
    faults: &[&str],
) -> Result<StackBound, Error> {
    let mut known = BTreeMap::new();
    let mut depth_of = |name: &str| {
        let function = program.named(name)?;
        depth(program, function, &mut BTreeSet::new(), &mut known)
    };
    let mut greatest = |names: &mut dyn Iterator<Item = &str>| {
        let mut most = (String::new(), 0);
        for name in names {
            let bytes = depth_of(name)? + EXCEPTION_FRAME;
            if bytes > most.1 {
                most = (name.to_owned(), bytes);
            }
        }
        Ok::<_, Error>(most)
    };
    let fault = greatest(&mut faults.iter().copied())?;
    let levels = levels
        .iter()
        .map(|level| greatest(&mut level.handlers.iter().map(String::as_str)))
        .collect::<Result<_, _>>()?;
    let mut idle = 0;
    for name in start {
        idle += frame(program.named(name)?);
    }
    Ok(StackBound {
        initialisation: start.first().map_or(Ok(0), |name| depth_of(name))?,
        idle,
        levels,
        fault,
    })
}
