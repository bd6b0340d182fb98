//! For how long something has lasted.

use crate::timing::CONTROL_PERIOD_MS;

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
        // As `count >= periods(time_ms)`, without a division.
        let exceeds = (i32::from(self.0) + 1) * CONTROL_PERIOD_MS > time_ms;
        self.0 > 0 && (exceeds || self.0 == u16::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::timing::periods;

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
    fn a_condition_has_lasted_after_the_whole_control_periods_of_the_time() {
        for time_ms in (-5..50).chain([262_139, 262_140, i32::MAX]) {
            let limit = periods(time_ms);
            for count in [1, limit - 1, limit, limit.saturating_add(1)] {
                let lasted = Lasting(count).update(None, time_ms);
                assert_eq!(
                    lasted,
                    count > 0 && count >= limit,
                    "{count} in {time_ms} ms"
                );
            }
        }
    }

    #[test]
    fn the_count_ends_and_does_not_wrap() {
        let mut lasting = Lasting(u16::MAX);
        assert!(lasting.update(Some(true), i32::MAX));
    }
}
