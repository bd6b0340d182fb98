//! What decides an injection without an experiment: how the undisturbed program first uses the
//! disturbed byte after it.
//!
//! This is the pruning of the fault space by definitions and uses (Güthoff and Sieh, "Combining
//! software-implemented and simulation-based fault injection into a single fault injection method",
//! FTCS 1995).

use std::collections::HashMap;
use std::ops::Range;

/// How an injection is decided.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Decision {
    /// By an experiment.
    Simulate,
    /// It has no effect: what it disturbs is overwritten before it is read, or never read.
    NoEffect,
    /// As all that are read first by this pass of a check, which tells whether any bit differs.
    Checked(u32),
}

impl Decision {
    /// The decision as a number.
    pub fn to_number(self) -> u32 {
        match self {
            Self::Simulate => 0,
            Self::NoEffect => 1,
            Self::Checked(pass) => pass.saturating_add(2),
        }
    }

    /// The decision of this number.
    pub fn from_number(number: u32) -> Self {
        match number {
            0 => Self::Simulate,
            1 => Self::NoEffect,
            more => Self::Checked(more - 2),
        }
    }
}

/// How bytes are used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Use {
    /// Read, or executed.
    Read,
    /// Overwritten.
    Write,
    /// Read by this pass of a check.
    Check(u32),
    /// Overwritten with what they were before the last pass of a check.
    Restore,
}

/// Injections into bytes that are not decided yet.
#[derive(Debug)]
pub struct Undecided {
    /// The injections into each byte of these ranges, by their indices.
    ranges: Vec<(Range<u64>, Vec<Vec<u32>>)>,
    /// The pass that has read an injection first.
    first_passes: HashMap<u32, u32>,
    /// Whether a check decides. Otherwise it is no use.
    pub do_checks_decide: bool,
}

impl Undecided {
    /// None in these ranges of the memory yet.
    pub fn new(ranges: &[Range<u64>], do_checks_decide: bool) -> Self {
        let empty = |range: &Range<u64>| {
            let bytes = (range.end - range.start) as usize;
            (range.clone(), vec![Vec::new(); bytes])
        };
        Self {
            ranges: ranges.iter().map(empty).collect(),
            first_passes: HashMap::new(),
            do_checks_decide,
        }
    }

    /// Adds an injection; returns whether a range contains its byte.
    pub fn add(&mut self, index: u32, address: u64) -> bool {
        let byte = self.at(address).and_then(|bytes| bytes.first_mut());
        byte.map(|injections| injections.push(index)).is_some()
    }

    /// These bytes are used: returns each injection that this decides.
    pub fn decide(&mut self, address: u64, bytes: usize, usage: Use) -> Vec<(u32, Decision)> {
        let decision = match usage {
            Use::Read => Decision::Simulate,
            Use::Write => Decision::NoEffect,
            Use::Check(pass) if self.do_checks_decide => Decision::Checked(pass),
            Use::Check(_) => return Vec::new(),
            Use::Restore => return self.restore(address, bytes),
        };
        let used = self.at(address).unwrap_or_default().iter_mut().take(bytes);
        let decided: Vec<u32> = used.flat_map(std::mem::take).collect();
        let decide = |index: u32| match self.first_pass(index) {
            // The computation that overwrites it may be repeated.
            Some(_) => (index, Decision::Simulate),
            None => (index, decision),
        };
        decided.into_iter().map(decide).collect()
    }

    /// Injections that a pass has read are in what is restored; the others are overwritten.
    fn restore(&mut self, address: u64, bytes: usize) -> Vec<(u32, Decision)> {
        let noted = std::mem::take(&mut self.first_passes);
        let used = self.at(address).unwrap_or_default().iter_mut().take(bytes);
        let overwritten = used.flat_map(|injections| {
            let is_overwritten = |index: &mut u32| !noted.contains_key(index);
            injections.extract_if(.., is_overwritten)
        });
        let decided = overwritten.map(|index| (index, Decision::NoEffect));
        let decided = decided.collect();
        self.first_passes = noted;
        decided
    }

    /// Notes that a pass of a check reads these bytes, which decides only with what follows.
    /// Returns the injections that nothing has read before.
    pub fn note(&mut self, address: u64, bytes: usize, pass: u32) -> Vec<u32> {
        if !self.do_checks_decide {
            return Vec::new();
        }
        let mut noted = std::mem::take(&mut self.first_passes);
        let read = self.at(address).unwrap_or_default().iter().take(bytes);
        let is_first = |index: &&u32| !noted.contains_key(index);
        let first: Vec<u32> = read.flatten().filter(is_first).copied().collect();
        noted.extend(first.iter().map(|index| (*index, pass)));
        self.first_passes = noted;
        first
    }

    /// The pass of a check by which an injection was read first, if nothing else did before.
    pub fn first_pass(&self, index: u32) -> Option<u32> {
        self.first_passes.get(&index).copied()
    }

    /// The bytes from this address on.
    fn at(&mut self, address: u64) -> Option<&mut [Vec<u32>]> {
        let mut ranges = self.ranges.iter_mut();
        let (range, bytes) = ranges.find(|(range, _)| range.contains(&address))?;
        bytes.get_mut((address - range.start) as usize..)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_use_of_a_byte_decides_its_injections() {
        let mut undecided = Undecided::new(&[0x100..0x108, 0x200..0x204], true);
        for (index, address) in [0x100, 0x103, 0x103, 0x200, 0x203].into_iter().enumerate() {
            assert!(undecided.add(index as u32, address));
        }
        assert!(!undecided.add(9, 0x108));
        assert_eq!(undecided.decide(0x104, 4, Use::Read), []);
        let written = undecided.decide(0x102, 2, Use::Write);
        assert_eq!(written, [(1, Decision::NoEffect), (2, Decision::NoEffect)]);
        assert_eq!(undecided.decide(0x103, 1, Use::Read), []);
        let read = undecided.decide(0x100, 4, Use::Read);
        assert_eq!(read, [(0, Decision::Simulate)]);
        let checked = undecided.decide(0x200, 4, Use::Check(7));
        let pass = Decision::Checked(7);
        assert_eq!(checked, [(3, pass), (4, pass)]);
    }

    #[test]
    fn an_injection_that_a_pass_has_read_is_restored_and_decided_by_its_first_other_use() {
        let mut undecided = Undecided::new(std::slice::from_ref(&(0..8)), true);
        for index in 0..2 {
            assert!(undecided.add(index, 0));
        }
        assert_eq!(undecided.note(0, 4, 5), [0, 1]);
        assert!(undecided.add(2, 1));
        assert!(undecided.note(0, 1, 6).is_empty());
        let restored = undecided.decide(0, 8, Use::Restore);
        assert_eq!(restored, [(2, Decision::NoEffect)]);
        assert_eq!(
            [0, 2].map(|index| undecided.first_pass(index)),
            [Some(5), None]
        );
        let written = undecided.decide(0, 1, Use::Write);
        assert_eq!(written, [(0, Decision::Simulate), (1, Decision::Simulate)]);
    }

    #[test]
    fn a_check_that_does_not_decide_is_no_use() {
        let mut undecided = Undecided::new(std::slice::from_ref(&(0..4)), false);
        assert!(undecided.add(0, 1));
        assert_eq!(undecided.decide(0, 4, Use::Check(1)), []);
        assert_eq!(undecided.decide(0, 4, Use::Read), [(0, Decision::Simulate)]);
    }

    #[test]
    fn a_decision_is_the_same_after_its_way_as_a_number() {
        for decision in [
            Decision::Simulate,
            Decision::NoEffect,
            Decision::Checked(0),
            Decision::Checked(70_000),
        ] {
            assert_eq!(Decision::from_number(decision.to_number()), decision);
        }
    }
}
