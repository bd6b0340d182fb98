//! The bounds as Markdown.

use std::fmt::Write as _;

use program_handlers::STEP_BEGINS_US;

use crate::{Bounds, Cost, StackBound};

/// Clock of the core, Hz.
const CORE_HZ: f64 = 168e6;

const HEAD: &str = "\
# Bounds for all inputs

Written by `cargo run --manifest-path assurance/Cargo.toml -p static-bounds -- --write`, which computes them from the
instructions of the actuator board's program; a test refuses a program that exceeds the stack or the PWM period. The
program has no recursion, no call by pointer and no stack frame of a variable size, which the computation checks. Its
call graph and control-flow graphs are therefore exact. Every branch is assumed possible, and every loop is executed as
often as `assurance/bounds/loops.txt` says, with the reason of each bound; sizes of copies are checked against it.

";

const STACK: &str = "\
## Stack

The initialisation runs before any interrupt is enabled. After it one handler of each priority can run, with its
exception frame of 108 bytes, and the handler of a fault on top.

| level | bytes |
|---|---|
";

const TIME: &str = "
## Execution time of the control period

The handlers of the control loop, which nothing preempts. Cycles are those of the Cortex-M4 Technical Reference Manual with memory that answers at once. The
last column adds five wait states for every line of 16 bytes of instructions and for every word that is loaded, as if the
flash had neither prefetch nor caches: the program switches the operand cache off while it erases and writes. In that
column the control step must end before the next PWM edge. Its bound contains an excitation that was not computed in
advance and all faults at once. Waits of the peripheral buses come in addition, at most 14 cycles an access (IHI 0024).

| handler | task | times | instructions | cycles | us | us without caches |
|---|---|---|---|---|---|---|
";

fn micros(cycles: u64) -> f64 {
    cycles as f64 / CORE_HZ * 1e6
}

fn time_row(text: &mut String, name: &str, times: u64, cost: Cost) {
    let _ = writeln!(
        text,
        "| {name} | {times} | {} | {} | {:.1} | {:.1} |",
        cost.instructions,
        cost.cycles,
        micros(cost.cycles),
        micros(cost.cycles_without_caches())
    );
}

impl Bounds {
    /// The document of the bounds.
    pub fn document(&self) -> String {
        let StackBound {
            initialisation,
            idle,
            levels,
            fault,
        } = &self.stack;
        let mut text = [HEAD, STACK].concat();
        let rows = [("initialisation", initialisation), ("idle", idle)].into_iter();
        let handlers = levels.iter().chain([fault]);
        let total = self.stack.total();
        for (name, bytes) in rows
            .chain(handlers.map(|(name, bytes)| (name.as_str(), bytes)))
            .chain([("in total", &total)])
        {
            let _ = writeln!(text, "| {name} | {bytes} |");
        }
        text.push_str(TIME);
        for bound in &self.times {
            let names = format!("{} | {}", bound.handler.interrupt, bound.handler.task);
            time_row(&mut text, &names, bound.handler.runs, bound.cost);
        }
        time_row(&mut text, "in total |", 1, self.period());
        let _ = writeln!(
            text,
            "\nThe control step begins at most {STEP_BEGINS_US} us after a PWM edge, and the next edge is 1000 us after that edge."
        );
        text
    }
}
