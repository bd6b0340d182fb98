//! Worst-case stack use from the call graph.

use std::collections::{BTreeMap, BTreeSet};

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

/// The levels of a program, lowest first: from the attributes
/// `#[task(binds = $name, priority = N)]` of its tasks, and from the invocation
/// `actuator_program! {..}` of a board, which lists interrupts in the order of the names.
///
/// # Errors
/// If an attribute has no number, or a name has no interrupt.
pub fn interrupt_levels(tasks: &str, board: &str) -> Result<Vec<InterruptLevel>, Error> {
    let names = tasks
        .split('$')
        .filter_map(|rest| rest.split_once(":ident"));
    let names = names.map(|(name, _)| name);
    let invocation = board
        .split_once("actuator_program!")
        .map_or("", |(_, rest)| rest);
    let is_interrupt = |word: &&str| word.starts_with(|c: char| c.is_ascii_uppercase());
    let interrupts = invocation
        .split(|c: char| !(c.is_ascii_alphanumeric() || c == '_'))
        .filter(is_interrupt);
    let interrupts: BTreeMap<_, _> = names.zip(interrupts).collect();

    let mut levels = BTreeMap::<u8, Vec<String>>::new();
    for (at, found) in tasks.match_indices("binds = $") {
        let attribute = &tasks[at + found.len()..];
        let name = attribute
            .split(',')
            .next()
            .and_then(|name| interrupts.get(name));
        let priority = attribute.split_once("priority = ").and_then(|(_, rest)| {
            rest.split(|c: char| !c.is_ascii_digit())
                .next()?
                .parse()
                .ok()
        });
        let (Some(name), Some(priority)) = (name, priority) else {
            return Err(Error::Table {
                line: tasks[..at].lines().count(),
                what: "a task without an interrupt or without `priority = NUMBER`".into(),
            });
        };
        levels.entry(priority).or_default().push((*name).into());
    }
    let levels = levels.into_iter();
    Ok(levels
        .map(|(priority, handlers)| InterruptLevel { priority, handlers })
        .collect())
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_come_from_the_attributes_of_the_tasks() {
        let tasks = "(a: $a:ident, b: [$b:ident, $c:ident]) #[task(binds = $a, priority = 4)]\n\
                     #[task(\n binds = $b,\n priority = 1)] #[task(binds = $c, priority = 4, x)]";
        let board = "actuator_program! { a: A_1, b: [B, C] }";
        let levels = interrupt_levels(tasks, board).unwrap();
        let named = |priority, names: &[&str]| InterruptLevel {
            priority,
            handlers: names.iter().map(|name| (*name).to_owned()).collect(),
        };
        assert_eq!(levels, [named(1, &["B"]), named(4, &["A_1", "C"])]);
        assert!(interrupt_levels("$a:ident #[task(binds = $a)]", board).is_err());
        assert!(interrupt_levels(tasks, "").is_err());
    }
}
