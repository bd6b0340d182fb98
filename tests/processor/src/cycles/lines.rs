//! The lines of the flash that are certainly in a cache.
//!
//! RM0090, section 3.5.2: the flash is read in lines of 128 bits. The cache of instructions holds
//! 64 of them, that of operands 8, and a new one replaces that which was used least recently. A
//! line that is read because of a miss is copied into it. Whether one that was prefetched is copied
//! as well, or one that the prefetch buffer holds counts as used, the manual does not say. Hence a
//! line is certainly in the cache only if a branch from elsewhere went to it, and fewer other lines
//! than the cache holds were used since the last such branch. Operands are not prefetched.

use std::collections::VecDeque;

/// Bytes of a line, as a shift.
const LINE_BITS: u32 = 4;

/// The line of an address.
pub fn line_of(address: u32) -> u32 {
    address >> LINE_BITS
}

#[derive(Debug, Clone, Copy)]
struct Line {
    number: u32,
    /// When it was used last.
    used: u64,
    /// When a branch went to it last.
    branched: Option<u64>,
}

/// The lines that were used last, the latest first.
#[derive(Debug)]
pub struct Lines {
    capacity: usize,
    recent: VecDeque<Line>,
    now: u64,
}

impl Lines {
    /// An empty cache of this number of lines.
    pub fn new(capacity: usize) -> Self {
        Self {
            capacity,
            recent: VecDeque::new(),
            now: 0,
        }
    }

    /// Uses a line; returns whether it certainly was in the cache.
    pub fn fetch(&mut self, number: u32, is_branch: bool) -> bool {
        self.now += 1;
        let found = self.recent.iter().position(|line| line.number == number);
        let before = found
            .and_then(|at| self.recent.remove(at))
            .and_then(|line| line.branched);
        let is_certain = before.is_some_and(|branched| {
            self.recent
                .iter()
                .take_while(|line| line.used > branched)
                .count()
                < self.capacity
        });
        self.recent.push_front(Line {
            number,
            used: self.now,
            branched: if is_branch { Some(self.now) } else { before },
        });
        self.recent.truncate(2 * self.capacity);
        is_certain
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_kept_for_63_others_after_a_branch_to_it() {
        for (others, expected) in [(0, true), (63, true), (64, false)] {
            let mut lines = Lines::new(64);
            assert!(!lines.fetch(1000, true));
            (0..others).for_each(|other| {
                lines.fetch(other, false);
            });
            assert_eq!(lines.fetch(1000, true), expected, "{others}");
        }
    }

    #[test]
    fn a_line_that_was_only_prefetched_is_not_certain() {
        let mut lines = Lines::new(64);
        assert!(!lines.fetch(7, false));
        assert!(!lines.fetch(8, false));
        assert!(!lines.fetch(7, true));
        assert!(lines.fetch(7, false));
    }

    #[test]
    fn using_a_line_in_sequence_does_not_keep_it() {
        let mut lines = Lines::new(64);
        lines.fetch(1000, true);
        for other in 0..63 {
            lines.fetch(other, false);
        }
        assert!(lines.fetch(1000, false));
        lines.fetch(63, false);
        assert!(!lines.fetch(1000, true));
    }
}
