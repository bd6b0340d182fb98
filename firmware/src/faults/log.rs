//! What is latched, and what has been.

use super::{Fault, FaultSet};

/// How many faults the history holds.
pub const HISTORY: usize = 8;

/// A fault and when it was latched.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FaultRecord {
    /// The fault.
    pub fault: Fault,
    /// The control period in which it was latched, counted from the reset.
    pub tick: u32,
}

/// Latched faults until they are acknowledged, and a history that outlives that.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FaultLog {
    latched: FaultSet,
    first: Option<FaultRecord>,
    /// The last one first.
    history: [Option<FaultRecord>; HISTORY],
    count: u32,
}

impl FaultLog {
    /// Latches a fault; one that is latched already is left as it is.
    pub fn latch(&mut self, fault: Fault, tick: u32) {
        if self.latched.contains(fault) {
            return;
        }
        let record = FaultRecord { fault, tick };
        if self.latched.is_empty() {
            self.first = Some(record);
        }
        self.latched.put(fault, true);
        self.count = self.count.saturating_add(1);
        let mut newest = Some(record);
        for place in &mut self.history {
            core::mem::swap(place, &mut newest);
        }
    }

    /// Takes note: nothing is latched any more; the history stays.
    pub fn acknowledge(&mut self) {
        self.latched = FaultSet::EMPTY;
        self.first = None;
    }

    /// Empties the history; what is latched stays latched.
    pub fn clear_history(&mut self) {
        self.history = [None; HISTORY];
        self.count = 0;
    }

    /// What is latched.
    pub fn latched(&self) -> FaultSet {
        self.latched
    }

    /// The fault with which it began: of those latched the one that came first.
    pub fn first(&self) -> Option<FaultRecord> {
        self.first
    }

    /// The last one, acknowledged or not.
    pub fn last(&self) -> Option<FaultRecord> {
        self.history[0]
    }

    /// The last ones, the last of them first.
    pub fn history(&self) -> impl Iterator<Item = FaultRecord> + '_ {
        self.history.iter().copied().flatten()
    }

    /// How many were latched since the reset, or since the history was emptied.
    pub fn count(&self) -> u32 {
        self.count
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_and_the_last_are_kept_and_none_is_counted_twice() {
        let mut log = FaultLog::default();
        log.latch(Fault::Stall, 5);
        log.latch(Fault::OverCurrent, 6);
        log.latch(Fault::Stall, 7);
        assert_eq!(log.first().unwrap().fault, Fault::Stall);
        assert_eq!(log.last().unwrap().fault, Fault::OverCurrent);
        assert_eq!(log.count(), 2);
        log.acknowledge();
        assert!(log.latched().is_empty() && log.first().is_none());
        assert_eq!(log.last().unwrap().tick, 6);
        log.latch(Fault::BusOff, 9);
        assert_eq!(log.first(), log.last());
    }

    #[test]
    fn the_history_holds_the_last_eight() {
        let mut log = FaultLog::default();
        for (tick, fault) in Fault::ALL.into_iter().enumerate() {
            log.latch(fault, tick as u32);
        }
        let ticks = log.history().map(|record| record.tick);
        assert!(ticks.eq((11..19).rev()));
        log.clear_history();
        assert_eq!((log.history().count(), log.count()), (0, 0));
        assert!(log.latched().contains(Fault::Stall));
    }
}
