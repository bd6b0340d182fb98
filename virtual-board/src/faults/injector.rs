//! Executes a fault plan: start and end of its faults.

use std::collections::BTreeSet;

use super::{Fault, Planned, Trigger};

/// An active fault.
#[derive(Debug, Clone)]
struct ActiveFault {
    until_ns: u64,
    fault: Fault,
}

/// Start or end of a fault.
#[derive(Debug, Clone, PartialEq)]
pub struct Change {
    /// The fault.
    pub fault: Fault,
    /// Whether it starts.
    pub begins: bool,
}

/// Fault plan of a run.
#[derive(Debug, Clone, Default)]
pub struct Injector {
    pending: Vec<Planned>,
    active: Vec<ActiveFault>,
}

impl Injector {
    /// Before the start of the plan.
    pub fn new(plan: Vec<Planned>) -> Self {
        Self {
            pending: plan,
            active: Vec::new(),
        }
    }

    /// Adds a fault during the run.
    pub fn add(&mut self, planned: Planned) {
        self.pending.push(planned);
    }

    /// Functions at whose entries faults start, each once.
    pub fn symbols(&self) -> BTreeSet<&str> {
        let names = self
            .pending
            .iter()
            .filter_map(|planned| match &planned.trigger {
                Trigger::Symbol { name, .. } => Some(name.as_str()),
                _ => None,
            });
        names.collect()
    }

    /// Time of the next start or end of a fault, ns.
    pub fn next_ns(&self) -> Option<u64> {
        let begins = self
            .pending
            .iter()
            .filter_map(|planned| match planned.trigger {
                Trigger::At { ns } => Some(ns),
                _ => None,
            });
        let ends = self.active.iter().map(|fault| fault.until_ns);
        begins.chain(ends).min()
    }

    /// Instruction count of the next start of a fault.
    pub fn next_instruction(&self) -> Option<u64> {
        let counts = self
            .pending
            .iter()
            .filter_map(|planned| match planned.trigger {
                Trigger::Instruction { count } => Some(count),
                _ => None,
            });
        counts.min()
    }

    /// Counts the entry of a function.
    pub fn count_entry(&mut self, at: &str) {
        for planned in &mut self.pending {
            if let Trigger::Symbol { name, hit } = &mut planned.trigger
                && name == at
            {
                *hit -= 1;
            }
        }
    }

    /// Faults that have ended and started since the last call.
    pub fn due(&mut self, now_ns: u64, instructions: u64) -> Vec<Change> {
        let ends = |fault: &mut ActiveFault| fault.until_ns <= now_ns;
        let mut changes: Vec<_> = (self.active.extract_if(.., ends))
            .map(|ended| Change {
                fault: ended.fault,
                begins: false,
            })
            .collect();
        let begins = |planned: &mut Planned| match planned.trigger {
            Trigger::At { ns } => ns <= now_ns,
            Trigger::Instruction { count } => count <= instructions,
            Trigger::Symbol { hit, .. } => hit == 0,
        };
        let begun: Vec<_> = self.pending.extract_if(.., begins).collect();
        for planned in begun {
            changes.push(Change {
                fault: planned.fault.clone(),
                begins: true,
            });
            if let Some(for_ns) = planned.for_ns {
                self.active.push(ActiveFault {
                    until_ns: now_ns + for_ns,
                    fault: planned.fault,
                });
            }
        }
        changes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_begins_in_its_time_and_ends_in_its_time() {
        let mut injector = Injector::new(vec![Planned::at_ms(2, Fault::Jam).for_ms(3)]);
        let fault = Fault::Jam;
        let change = |begins| Change {
            fault: fault.clone(),
            begins,
        };
        assert_eq!(injector.next_ns(), Some(2_000_000));
        assert_eq!(injector.due(1_999_999, 0), []);
        assert_eq!(injector.due(2_000_006, 0), [change(true)]);
        assert_eq!(injector.next_ns(), Some(5_000_006));
        assert_eq!(injector.due(5_000_006, 0), [change(false)]);
        assert_eq!(injector.next_ns(), None);
    }

    #[test]
    fn instruction_counts_and_function_entries_trigger_once() {
        let planned = |trigger| Planned {
            trigger,
            for_ns: None,
            fault: Fault::Jam,
        };
        let name = "step".to_owned();
        let mut injector = Injector::new(vec![
            planned(Trigger::Instruction { count: 100 }),
            planned(Trigger::Symbol { name, hit: 2 }),
        ]);
        assert_eq!(injector.due(0, 99).len(), 0);
        assert_eq!(injector.due(0, 100).len(), 1);
        injector.count_entry("other");
        injector.count_entry("step");
        assert_eq!(injector.due(0, 101).len(), 0);
        injector.count_entry("step");
        assert_eq!(injector.due(0, 102).len(), 1);
        assert_eq!(injector.due(0, 103).len(), 0);
    }
}
