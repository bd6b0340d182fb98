//! For how long something has lasted.

use crate::timing::periods;

/// Counts control periods in which a condition held; one in which it did not makes up for one of
/// them, so that a condition that comes and goes counts as well.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Lasting(u16);

impl Lasting {
    /// The count.
    pub fn periods(self) -> u16 {
        self.0
    }

    /// Takes whether the condition holds, `None` where that is not known: then the count stays.
    /// Returns whether it has held for `time_ms` longer than not, one control period at the least.
    #[inline(always)]
    pub fn update(&mut self, holds: Option<bool>, time_ms: i32) -> bool {
        // Most conditions do not hold.
        if self.0 == 0 && holds != Some(true) {
            return false;
        }
        self.count(holds, time_ms)
    }

    /// These control periods were counted as some in which the condition held, and it did not.
    #[inline(always)]
    pub fn take_back(&mut self, periods: u16) {
        self.0 = self.0.saturating_sub(periods.saturating_mul(2));
    }

    #[inline(never)]
    fn count(&mut self, holds: Option<bool>, time_ms: i32) -> bool {
        let limit = periods(time_ms);
        self.0 = match holds {
            // It ends at its limit: a condition that has held for long ends at once.
            Some(true) if self.0 < limit => self.0 + 1,
            Some(false) => self.0 - 1,
            _ => self.0,
        };
        self.0 >= limit
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
    fn a_condition_that_has_held_for_long_ends_at_once() {
        let mut lasting = Lasting::default();
        assert!(
            (0..1000)
                .map(|_| lasting.update(Some(true), 8))
                .skip(1)
                .all(|it| it)
        );
        assert!(!lasting.update(Some(false), 8));
    }

    #[test]
    fn a_condition_that_holds_for_more_than_half_of_the_time_lasts() {
        let until = |pattern: [bool; 4]| {
            let mut lasting = Lasting::default();
            let mut found = pattern.into_iter().cycle().take(1000);
            found.position(|holds| lasting.update(Some(holds), 40))
        };
        // Ten control periods, of two in four.
        assert_eq!(until([true, true, true, false]), Some(17));
        assert_eq!(until([true, true, false, false]), None);
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
