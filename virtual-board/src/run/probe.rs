//! Counts the instructions of functions, from entry to return.

use std::collections::BTreeMap;

use super::firmware::{Firmware, FirmwareError};

/// A call of a function, including all functions that it called and interrupts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Span {
    /// Its start, ns.
    pub at_ns: u64,
    /// From its first instruction to its return, exclusive.
    pub instructions: u64,
}

#[derive(Debug, Clone, Default)]
struct Probe {
    name: String,
    entered: Vec<(u64, u64)>,
    spans: Vec<Span>,
}

/// What a watched address is for a probe.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mark {
    Entry(usize),
    Exit(usize),
}

/// All probes of a run.
#[derive(Debug, Clone, Default)]
pub(super) struct Probes {
    probes: Vec<Probe>,
    marks: BTreeMap<u64, Vec<Mark>>,
}

impl Probes {
    pub fn try_new(firmware: &Firmware, names: &[String]) -> Result<Self, FirmwareError> {
        let mut probes = Self::default();
        for (index, name) in names.iter().enumerate() {
            let function = firmware.function(name)?;
            probes.mark(function.entry, Mark::Entry(index));
            for exit in function.exits {
                probes.mark(exit, Mark::Exit(index));
            }
            probes.probes.push(Probe {
                name: name.clone(),
                ..Probe::default()
            });
        }
        Ok(probes)
    }

    fn mark(&mut self, address: u64, mark: Mark) {
        self.marks.entry(address).or_default().push(mark);
    }

    /// Addresses to watch.
    pub fn addresses(&self) -> impl Iterator<Item = u64> {
        self.marks.keys().copied()
    }

    /// To be called when the core reaches a watched address.
    pub fn on_address(&mut self, address: u64, at_ns: u64, instructions: u64) {
        for mark in self.marks.get(&address).into_iter().flatten() {
            match *mark {
                Mark::Entry(index) => self.probes[index].entered.push((at_ns, instructions)),
                Mark::Exit(index) => {
                    let probe = &mut self.probes[index];
                    if let Some((at_ns, before)) = probe.entered.pop() {
                        let instructions = instructions - before;
                        probe.spans.push(Span {
                            at_ns,
                            instructions,
                        });
                    }
                }
            }
        }
    }

    /// Discards calls that have not returned: after a reset they never return.
    pub fn discard_open_calls(&mut self) {
        self.probes
            .iter_mut()
            .for_each(|probe| probe.entered.clear());
    }

    /// The spans by the functions' names.
    pub fn into_spans(self) -> BTreeMap<String, Vec<Span>> {
        let spans = self.probes.into_iter();
        spans.map(|probe| (probe.name, probe.spans)).collect()
    }
}
