//! Worst-case execution time from the control-flow graphs.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::iter::Sum;
use std::ops::{Add, Mul};

use crate::loops::LoopBounds;
use crate::program::{Function, Program};
use crate::routine::Routine;
use crate::{Error, graph};

/// Wait states of the flash at 168 MHz and 3.3 V (RM0090, table 11).
const WAIT_STATES: u64 = 5;

/// Bytes that a read of the flash delivers (RM0090, section 3.5.2).
pub(crate) const LINE_BYTES: u64 = 16;

/// What an execution takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Cost {
    /// Executed instructions.
    pub instructions: u64,
    /// Cycles of the Cortex-M4F with memory that answers at once.
    pub cycles: u64,
    /// Lines of the flash that are read for instructions and for loads, which may be of the flash,
    /// in sixteenths.
    pub lines_16: u64,
}

impl Cost {
    /// Cycles if every line of the flash is read with all wait states, as without the prefetch and
    /// the caches of the flash interface.
    pub fn cycles_without_caches(self) -> u64 {
        self.cycles + WAIT_STATES * self.lines_16.div_ceil(LINE_BYTES)
    }

    /// The greater one of both, each figure by itself.
    pub(crate) fn max(self, other: Self) -> Self {
        Self {
            instructions: self.instructions.max(other.instructions),
            cycles: self.cycles.max(other.cycles),
            lines_16: self.lines_16.max(other.lines_16),
        }
    }
}

impl Add for Cost {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            instructions: self.instructions + other.instructions,
            cycles: self.cycles + other.cycles,
            lines_16: self.lines_16 + other.lines_16,
        }
    }
}

impl Mul<u64> for Cost {
    type Output = Self;

    fn mul(self, times: u64) -> Self {
        Self {
            instructions: self.instructions * times,
            cycles: self.cycles * times,
            lines_16: self.lines_16 * times,
        }
    }
}

impl Sum for Cost {
    fn sum<I: Iterator<Item = Self>>(costs: I) -> Self {
        costs.fold(Self::default(), Add::add)
    }
}

/// The worst-case times of functions of a program.
pub struct TimeBounds<'a> {
    program: &'a Program,
    bounds: &'a LoopBounds,
    known: RefCell<BTreeMap<u64, Cost>>,
}

impl<'a> TimeBounds<'a> {
    /// Times of this program with these bounds of its loops.
    pub fn new(program: &'a Program, bounds: &'a LoopBounds) -> Self {
        Self {
            program,
            bounds,
            known: RefCell::default(),
        }
    }

    /// The worst case of a function of this name with everything that it calls.
    ///
    /// # Errors
    /// If it is missing, or the table of bounds does not fit the loops of a function.
    pub fn of(&self, name: &str) -> Result<Cost, Error> {
        self.cost(self.program.named(name)?)
    }

    /// The addresses of the functions that a function of this name calls, itself included.
    ///
    /// # Errors
    /// If it is missing.
    pub fn reached(&self, name: &str) -> Result<BTreeSet<u64>, Error> {
        let mut reached = BTreeSet::new();
        let mut todo = vec![self.program.named(name)?];
        while let Some(function) = todo.pop() {
            if reached.insert(function.address) {
                for (_, callee) in &function.calls {
                    todo.push(self.program.at(*callee)?);
                }
            }
        }
        Ok(reached)
    }

    fn cost(&self, function: &Function) -> Result<Cost, Error> {
        if let Some(cost) = self.known.borrow().get(&function.address) {
            return Ok(*cost);
        }
        let cost = self.longest(function, &|bound| bound)?;
        self.known.borrow_mut().insert(function.address, cost);
        Ok(cost)
    }

    /// The worst case of a call: that of a memory routine depends on the size.
    fn of_call(&self, caller: &Function, at: u64, callee: &Function) -> Result<Cost, Error> {
        let size = Routine::of(callee).and_then(|routine| {
            let size = caller.greatest_before(at, routine.register)?;
            Some((size, routine.most))
        });
        match size {
            // The first execution of a header is the entry.
            Some((size, most)) => self.longest(callee, &|bound| {
                1 + (bound.saturating_sub(1) * size).div_ceil(most)
            }),
            None => self.cost(callee),
        }
    }

    /// The worst case of a function with its bounds as they apply to a call.
    fn longest(&self, function: &Function, applied: &dyn Fn(u64) -> u64) -> Result<Cost, Error> {
        let mut called = BTreeMap::<u64, Cost>::new();
        for (at, callee) in &function.calls {
            let cost = self.of_call(function, *at, self.program.at(*callee)?)?;
            called
                .entry(*at)
                .and_modify(|most| *most = most.max(cost))
                .or_insert(cost);
        }
        let headers = graph::loop_headers(function);
        let bounds = self.bounds.of(function, headers.len());
        if headers.len() != bounds.len() {
            return Err(Error::Loops {
                function: function.name.clone(),
                found: headers
                    .iter()
                    .map(|header| format!("{header:#x}"))
                    .collect(),
                expected: bounds.len(),
            });
        }
        let bounds: BTreeMap<_, _> = headers.iter().zip(bounds).collect();
        let own = |at: u64| {
            let instruction = &function.instructions[&at].0;
            let own = Cost {
                instructions: 1,
                cycles: instruction.cycles,
                lines_16: instruction.lines_16,
            };
            own + called.get(&at).copied().unwrap_or_default()
        };
        Ok(graph::longest(function, &own, &|header| {
            bounds.get(&header).map_or(1, |bound| applied(**bound))
        }))
    }
}
