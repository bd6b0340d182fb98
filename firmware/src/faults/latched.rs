//! Latched faults.

use super::{Fault, FaultSet};

/// The faults that are latched until they are acknowledged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LatchedFaults {
    all: FaultSet,
    first: Option<Fault>,
}

impl LatchedFaults {
    /// Latches a fault.
    pub fn latch(&mut self, fault: Fault) {
        self.first = self.first.or(Some(fault));
        self.all.put(fault, true);
    }

    /// Clears all of them.
    pub fn acknowledge(&mut self) {
        *self = Self::default();
    }

    /// All of them.
    pub fn all(&self) -> FaultSet {
        self.all
    }

    /// The one that was latched first.
    pub fn first(&self) -> Option<Fault> {
        self.first
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_fault_is_reported_until_all_are_acknowledged() {
        let mut latched = LatchedFaults::default();
        for fault in [Fault::Stall, Fault::OverCurrent, Fault::Stall] {
            latched.latch(fault);
        }
        assert_eq!(latched.first(), Some(Fault::Stall));
        assert_eq!(
            latched.all(),
            FaultSet::of(&[Fault::Stall, Fault::OverCurrent])
        );
        latched.acknowledge();
        assert!(latched.all().is_empty() && latched.first().is_none());
        latched.latch(Fault::BusOff);
        assert_eq!(latched.first(), Some(Fault::BusOff));
    }
}
