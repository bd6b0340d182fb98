//! Contents of the array after a loss of the supply during an operation.

use rand_pcg::{Pcg32, rand_core::Rng};

use super::operation::{Operation, Started};

/// Progress of an interrupted operation, and the random generator of the resulting bits.
#[derive(Debug, Clone)]
pub(super) struct Damage {
    operation: Operation,
    /// Elapsed eighths of its duration.
    eighths: u64,
    random: Pcg32,
}

impl Damage {
    /// `started`, interrupted at this instant. The same seed and instant give the same bits.
    pub fn new(started: &Started, seed: u64, at_ns: u64) -> Self {
        let whole_ns = (started.until_ns - started.from_ns).max(1);
        Self {
            operation: started.operation,
            eighths: at_ns.saturating_sub(started.from_ns) * 8 / whole_ns,
            random: Pcg32::new(seed, at_ns),
        }
    }

    pub fn operation(&self) -> Operation {
        self.operation
    }

    fn word(&mut self) -> u64 {
        u64::from(self.random.next_u32()) | u64::from(self.random.next_u32()) << 32
    }

    /// Content of a unit with this previous content. Of the bits that the operation changes, none
    /// has changed in the first eighth, and half of the remaining ones change in each further
    /// eighth.
    pub fn content_after(&mut self, held: u64) -> u64 {
        let mut changed = 0;
        for _ in 0..self.eighths {
            changed |= self.word();
        }
        let complete = self.operation.complete(held);
        held & !changed | complete & changed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn erase(eighths: u64) -> Damage {
        let started = Started {
            operation: Operation::Erase { base: 0, size: 8 },
            from_ns: 1000,
            until_ns: 9000,
        };
        Damage::new(&started, 1, 1000 + eighths * 1000)
    }

    #[test]
    fn an_operation_in_its_first_eighth_changes_nothing() {
        assert_eq!(erase(0).content_after(0x1234), 0x1234);
    }

    #[test]
    fn later_more_bits_have_changed_and_only_those_of_the_operation() {
        let ones = |eighths| erase(eighths).content_after(0).count_ones();
        assert!((20..44).contains(&ones(1)), "half: {}", ones(1));
        assert!(ones(7) > 60);
        let started = Started {
            operation: Operation::Program {
                address: 0,
                width: rigless::soc::Width::W32,
                value: 0x00ff_00ff,
            },
            from_ns: 0,
            until_ns: 16_000,
        };
        let left = Damage::new(&started, 1, 5_000).content_after(0xffff_ff00);
        assert_eq!(left & 0x00ff_0000, 0x00ff_0000);
        assert_eq!(left & 0xff, 0);
        assert!(left != 0xffff_ff00 && left != 0x00ff_0000);
    }

    #[test]
    fn the_same_seed_leaves_the_same_bits() {
        assert_eq!(erase(3).content_after(0), erase(3).content_after(0));
        assert_ne!(erase(3).content_after(0), erase(4).content_after(0));
    }
}
