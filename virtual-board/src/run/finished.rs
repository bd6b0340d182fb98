//! Results of a run.

use std::collections::BTreeMap;
use std::fmt;

use rigless::emulator;
use rigless::machine::Board;
use rigless::session::{Reset, Session};

use super::driver::Lockstep;
use super::probe::Span;
use crate::board::ActuatorBoard;
use crate::flash::{Interface, Operation};
use crate::plant::BoardPlant;
use crate::trace::Trace;

/// Accesses of the program that the emulation does not model. The results of a run are valid only
/// if there are no gaps.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Gaps(Vec<String>);

impl Gaps {
    pub(super) fn of<B: Board>(session: &Session<B>) -> Self {
        let mut gaps: Vec<String> = Vec::new();
        gaps.extend(session.unmapped().iter().map(ToString::to_string));
        let refused = session.refused().iter();
        gaps.extend(refused.map(|(at, fault)| format!("refused at={at:#010x}: {fault}")));
        gaps.extend(session.unimplemented().values().map(|gap| {
            let (instance, register, pc) = (gap.instance, gap.register, gap.program_counter);
            format!("unimplemented {instance}.{register} pc={pc:#010x}")
        }));
        let unrouted = session.unrouted().iter();
        gaps.extend(unrouted.map(|(instance, line)| format!("unrouted {instance} line {line}")));
        gaps.extend(session.told().map(|told| {
            let (instance, register) = (told.instance, told.register);
            format!(
                "not modelled {instance}.{register} at {} ns: {}",
                told.at.0, told.reason
            )
        }));
        Self(gaps)
    }

    /// Those that begin with none of these texts.
    #[must_use]
    pub fn except(&self, known: &[&str]) -> Self {
        let is_known = |gap: &&String| known.iter().any(|known| gap.starts_with(known));
        Self(
            self.0
                .iter()
                .filter(|gap| !is_known(gap))
                .cloned()
                .collect(),
        )
    }

    /// Whether there are no gaps.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl fmt::Display for Gaps {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.0.join("\n"))
    }
}

/// A finished run.
#[derive(Debug)]
pub struct Finished<S> {
    /// The script.
    pub script: S,
    /// The trace.
    pub trace: Trace,
    /// Accesses that the emulation does not model.
    pub gaps: Gaps,
    /// Every reset and its cause, without the first power-on.
    pub resets: Vec<Reset>,
    /// Calls of the probed functions.
    pub spans: BTreeMap<String, Vec<Span>>,
    /// Operations of the flash, in order.
    pub flash_operations: Vec<Operation>,
    /// Number of transfers from the encoder.
    pub encoder_reads: u64,
    /// Number of executed instructions.
    pub instructions: u64,
    /// Virtual time at the end, ns.
    pub end_ns: u64,
    /// The plant at the end.
    pub plant: BoardPlant,
}

impl<S> Finished<S> {
    pub(super) fn of(finished: emulator::Finished<ActuatorBoard, Lockstep<S>>) -> Self {
        let mut session = finished.session;
        let gaps = Gaps::of(&session);
        let resets = session.resets().to_vec();
        let board = session.board_mut();
        let flash_operations = board
            .chip
            .flash()
            .map_or_else(Vec::new, Interface::take_log);
        let encoder_reads = board.encoder_reads();
        let driver = finished.driver;
        let (end_ns, instructions) = driver.last;
        Self {
            script: driver.script,
            trace: driver.trace,
            gaps,
            resets,
            spans: driver.probes.into_spans(),
            flash_operations,
            encoder_reads,
            instructions,
            end_ns,
            plant: driver.plant,
        }
    }
}
