//! The bounds, and the times that they must keep.

use program_handlers::STEP_BEGINS_US;

use super::{Call, Cycles, EDGE, RECEPTION, STEP};
use crate::document::grouped;

/// Cycles of a PWM period, and of a control period.
pub const PWM_PERIOD: u64 = 168_000;
const CONTROL_PERIOD: u64 = 4 * PWM_PERIOD;

/// Cycles from the edge until the encoder has been read and the control step begins.
const ENCODER: u64 = STEP_BEGINS_US * PWM_PERIOD / 1000;

/// Cycles of the shortest frame at 1 Mbit/s: 47 bits with the pause before the next one.
const SHORTEST_FRAME: u64 = 47 * 168;

/// A bound, and the time that it must keep.
#[derive(Debug, Clone)]
pub struct Bound {
    /// What is bounded.
    pub name: &'static str,
    /// Cycles at most.
    pub cycles: u64,
    /// Cycles that there are.
    pub limit: u64,
}

impl Cycles {
    fn longest(&self, task: &str) -> Call {
        let longest = self.calls.get(&self.exception(task));
        longest.map(|longest| longest.most).unwrap_or_default()
    }

    /// These cycles with the frames that are received meanwhile at the full bus load.
    fn with_reception(&self, cycles: u64) -> u64 {
        let reception = self.longest(RECEPTION).cycles;
        let mut sum = cycles;
        loop {
            let frames = sum.div_ceil(SHORTEST_FRAME) + 1;
            let next = cycles + frames * reception;
            if next <= sum || next > CONTROL_PERIOD {
                return next;
            }
            sum = next;
        }
    }

    /// The bounds.
    pub fn bounds(&self) -> [Bound; 2] {
        let before_step = ENCODER.max(self.longest(EDGE).cycles);
        let bound = |name, cycles, limit| Bound {
            name,
            cycles,
            limit,
        };
        [
            bound(
                "all handlers of a control period",
                self.with_reception(self.longest_period.cycles),
                CONTROL_PERIOD,
            ),
            bound(
                "edge, encoder and control step, until the next edge",
                before_step + self.longest(STEP).cycles,
                PWM_PERIOD,
            ),
        ]
    }

    /// Executed instructions of all handlers in a control period, mean.
    fn mean_instructions(&self) -> u64 {
        let periods = self.calls.get(&self.exception(STEP));
        let periods = periods.map_or(1, |step| step.calls);
        let sum: u64 = self.calls.values().map(|it| it.sum.instructions).sum();
        sum / periods
    }

    /// The bounds as Markdown.
    pub fn table(&self) -> String {
        let mut text = String::from(
            "| interrupt | instructions at most | cycles at most | cycles per instruction, mean |\n|---|---|---|---|\n",
        );
        let mut row = |name: &str, most: Call, sum: Call| {
            let ratio = sum.cycles as f64 / sum.instructions.max(1) as f64;
            text += &format!(
                "| {name} | {} | {} | {ratio:.2} |\n",
                grouped(most.instructions),
                grouped(most.cycles)
            );
        };
        let mut all = Call::default();
        for handler in &self.handlers {
            let longest = self.calls.get(&handler.exception);
            let longest = longest.copied().unwrap_or_default();
            all = all.plus(longest.sum);
            let name = format!("`{}`: {}", handler.interrupt, handler.task);
            row(&name, longest.most, longest.sum);
        }
        row("all of a control period", self.longest_period, all);
        let mean = grouped(self.mean_instructions());
        text += &format!("\nA control period executes {mean} instructions in the mean.\n");
        text += "\n| bound, with the frames received meanwhile on a full bus | cycles at most | of |\n|---|---|---|\n";
        for bound in self.bounds() {
            let (cycles, limit) = (grouped(bound.cycles), grouped(bound.limit));
            text += &format!("| {} | {cycles} | {limit} |\n", bound.name);
        }
        text
    }
}
