//! The bounds, and the times that they must keep.

use super::{Call, Cycles, Turn};
use crate::document::{HANDLERS, grouped};

/// Cycles of a PWM period, and of a control period.
pub const PWM_PERIOD: u64 = 168_000;
const CONTROL_PERIOD: u64 = 4 * PWM_PERIOD;

/// Cycles from the edge until the encoder has been read and the control step begins: 38 us.
const ENCODER: u64 = 38 * 168;

/// Cycles after which the node takes no further frame in a turn: `INTAKE_CYCLES` of
/// `firmware/boards/shared/actuator/canopen_task/reception.rs`.
const INTAKE: u64 = 50_000;

/// Cycles of the shortest frame at 1 Mbit/s: 47 bits with the pause before the next one.
const SHORTEST_FRAME: u64 = 47 * 168;

/// Exceptions: edge, control step, turn of the node, received frame.
const EDGE: u32 = 41;
const STEP: u32 = 72;
const NODE: u32 = 98;
const RECEPTION: u32 = 36;

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
    fn longest(&self, exception: u32) -> Call {
        let longest = self.calls.get(&exception);
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

    /// A turn that begins at an edge, and takes its longest frame after this number of cycles.
    fn turn(&self, turn: Turn, intake: u64) -> u64 {
        let edge = self.longest(EDGE).cycles;
        self.with_reception(edge + turn.begin + intake + turn.frame + turn.end)
    }

    /// The bounds.
    pub fn bounds(&self) -> [Bound; 5] {
        let edge = self.longest(EDGE).cycles;
        let bound = |name, cycles, limit| Bound {
            name,
            cycles,
            limit,
        };
        [
            bound(
                "interrupts of a control period without the node",
                self.with_reception(self.longest_tick.cycles),
                CONTROL_PERIOD,
            ),
            bound(
                "edge, encoder and control step, until the next edge",
                self.with_reception(edge.max(ENCODER) + self.longest(STEP).cycles),
                PWM_PERIOD,
            ),
            bound(
                "longest executed turn of the node, until the next edge",
                self.with_reception(edge + self.longest(NODE).cycles),
                PWM_PERIOD,
            ),
            bound(
                "turn with 50,000 cycles of frames, then the longest one, without resets",
                self.turn(self.turns[0], INTAKE),
                PWM_PERIOD,
            ),
            bound(
                "turn that begins with a reset of the node",
                self.turn(self.turns[1], 0),
                PWM_PERIOD,
            ),
        ]
    }

    /// The bounds as Markdown.
    pub fn table(&self) -> String {
        let mut text = String::from(
            "| interrupt | instructions at most | cycles at most | without a cache | cycles per instruction, mean |\n|---|---|---|---|---|\n",
        );
        for (name, exception, function) in HANDLERS {
            let longest = self.calls.get(&exception).copied().unwrap_or_default();
            let (most, sum) = (longest.most, longest.sum);
            let ratio = sum.cycles as f64 / sum.instructions.max(1) as f64;
            text += &format!(
                "| `{name}`: {function} | {} | {} | {} | {ratio:.2} |\n",
                grouped(most.instructions),
                grouped(most.cycles),
                grouped(most.uncached)
            );
        }
        let [ordinary, reset] = self.turns;
        for (name, cycles) in [
            (
                "frame of a turn, or its process data, without resets",
                ordinary.frame,
            ),
            ("frame with a reset of the node", reset.frame),
            (
                "turn beside its frames",
                (ordinary.begin + ordinary.end).max(reset.begin + reset.end),
            ),
        ] {
            text += &format!("| {name} | | {} | | |\n", grouped(cycles));
        }
        text += "\n| bound, with the frames received meanwhile on a full bus | cycles at most | of |\n|---|---|---|\n";
        for bound in self.bounds() {
            let (cycles, limit) = (grouped(bound.cycles), grouped(bound.limit));
            text += &format!("| {} | {cycles} | {limit} |\n", bound.name);
        }
        text
    }
}
