//! Latched faults and the fault history.

use super::{Fault, FaultSet};

/// Number of faults in the history.
pub const HISTORY: usize = 8;

/// A fault and the time at which it was latched.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FaultRecord {
    /// The fault.
    pub fault: Fault,
    /// The control period in which it was latched, counted from the reset.
    pub tick: u32,
}

/// Latched faults until they are acknowledged, and a history that remains after that.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FaultLog {
    latched: FaultSet,
    first: Option<FaultRecord>,
    /// The last fault first.
    history: [Option<FaultRecord>; HISTORY],
    count: u32,
}

impl FaultLog {
    /// Latches a fault; without effect if it is latched already.
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
        for slot in &mut self.history {
            core::mem::swap(slot, &mut newest);
        }
    }

    /// Clears all latched faults; the history remains.
    pub fn acknowledge(&mut self) {
        self.latched = FaultSet::EMPTY;
        self.first = None;
    }

    /// The latched faults.
    pub fn latched(&self) -> FaultSet {
        self.latched
    }

    /// Of the latched faults, the one that was latched first.
    pub fn first(&self) -> Option<FaultRecord> {
        self.first
    }

    /// The last fault, acknowledged or not.
    pub fn last(&self) -> Option<FaultRecord> {
        self.history[0]
    }

    /// The faults of the history, the last one first.
    pub fn history(&self) -> impl Iterator<Item = FaultRecord> + '_ {
        self.history.iter().copied().flatten()
    }

    /// Number of faults latched since the reset, or since the history was emptied.
    pub fn count(&self) -> u32 {
        self.count
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_and_the_last_fault_are_kept_and_a_repeated_one_is_not_counted() {
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
        assert!(ticks.eq((16..24).rev()));
    }
}
