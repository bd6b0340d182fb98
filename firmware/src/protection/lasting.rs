//! For how long something has lasted.

use crate::timing::periods;

/// Counts control periods in a row in which a condition held.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Lasting(u16);

impl Lasting {
    /// Takes whether the condition holds, `None` where that is not known: then the count stays.
    /// Returns whether it has held for `time_ms`, one control period at the least.
    pub fn update(&mut self, holds: Option<bool>, time_ms: i32) -> bool {
        match holds {
            Some(true) => self.0 = self.0.saturating_add(1),
            Some(false) => self.0 = 0,
            None => {}
        }
        // Most conditions do not hold: no division then.
        self.0 > 0 && self.0 >= periods(time_ms)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_known_neither_counts_nor_clears() {
        let mut lasting = Lasting::default();
        assert!(!lasting.update(Some(true), 8));
        for _ in 0..100 {
            assert!(!lasting.update(None, 8));
        }
        assert!(lasting.update(Some(true), 8));
        assert!(lasting.update(None, 8));
        assert!(!lasting.update(Some(false), 8));
    }

    #[test]
    fn the_count_ends_and_does_not_wrap() {
        let mut lasting = Lasting(u16::MAX);
        assert!(lasting.update(Some(true), i32::MAX));
    }
}
