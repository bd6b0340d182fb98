//! A set of faults.

use super::Fault;

/// A set of faults: bit `n` for number `n`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub struct FaultSet(u32);

impl FaultSet {
    /// No fault.
    pub const EMPTY: Self = Self(0);

    /// The set of these faults.
    pub const fn of(faults: &[Fault]) -> Self {
        let mut bits = 0;
        let mut rest = faults;
        while let [fault, others @ ..] = rest {
            bits |= Self::bit(*fault);
            rest = others;
        }
        Self(bits)
    }

    const fn bit(fault: Fault) -> u32 {
        // Numbers are at most 24, so the mask has no effect; it removes the overflow check.
        1 << (fault.number() & 31)
    }

    /// The set of a number: bit `n` for the fault of number `n`.
    pub const fn of_bits(bits: u32) -> Self {
        Self(bits)
    }

    /// As a number: bit `n` for the fault of number `n`.
    pub const fn bits(self) -> u32 {
        self.0
    }

    /// Whether the set is empty.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Whether this fault is in the set.
    pub const fn contains(self, fault: Fault) -> bool {
        self.0 & Self::bit(fault) != 0
    }

    /// Inserts this fault if `present`.
    pub const fn put(&mut self, fault: Fault, present: bool) {
        self.0 |= (present as u32) << (fault.number() & 31);
    }

    /// Union of both sets.
    pub const fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Intersection of both sets.
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// The faults of this set that are not in the other.
    pub const fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// The fault with the lowest number.
    ///
    /// ```
    /// use firmware::faults::{Fault, FaultSet};
    /// let set = FaultSet::of(&[Fault::Stall, Fault::OverCurrent]);
    /// assert_eq!(set.first(), Some(Fault::OverCurrent));
    /// assert_eq!(FaultSet::EMPTY.first(), None);
    /// ```
    pub fn first(self) -> Option<Fault> {
        Fault::of_number(self.0.trailing_zeros() as u16)
    }

    /// All faults of the set in the order of their numbers.
    pub fn iter(self) -> impl Iterator<Item = Fault> {
        core::iter::successors(Some(self), |set| Some(Self(set.0 & set.0.wrapping_sub(1))))
            .map_while(Self::first)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use std::vec::Vec;

    use super::*;

    #[test]
    fn a_set_iterates_over_its_faults_in_the_order_of_their_numbers() {
        for bits in 0..1u32 << 19 {
            let expected: Vec<_> = Fault::ALL
                .into_iter()
                .filter(|fault| bits >> (fault.number() - 1) & 1 == 1)
                .collect();
            // All subsets of the lower numbers, and a sample of the rest.
            if bits > 1 << 10 && bits % 997 != 0 {
                continue;
            }
            let set = FaultSet::of(&expected);
            assert_eq!(set.bits(), bits << 1);
            assert!(set.iter().eq(expected.iter().copied()));
        }
    }

    #[test]
    fn union_intersection_and_difference_of_sets() {
        let (a, b) = (Fault::Stall, Fault::BusOff);
        let both = FaultSet::of(&[a]).or(FaultSet::of(&[b]));
        assert!(both.contains(a) && both.contains(b));
        assert_eq!(both.without(FaultSet::of(&[a])), FaultSet::of(&[b]));
        assert_eq!(both.and(FaultSet::of(&[a])), FaultSet::of(&[a]));
    }
}
