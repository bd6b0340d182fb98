//! Monitoring window: a condition that must hold for a time.

/// Time for which a condition has held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct HoldTimer {
    time_us: u32,
}

impl HoldTimer {
    /// A period of `PERIOD_US` microseconds: returns whether the condition has held for `time_ms`,
    /// measured from the start of the first period in which it held.
    pub fn step<const PERIOD_US: u32>(&mut self, holds: bool, time_ms: u16) -> bool {
        if !holds {
            self.time_us = 0;
            return false;
        }
        let reached = self.time_us >= u32::from(time_ms) * 1000;
        self.time_us = self.time_us.saturating_add(PERIOD_US);
        reached
    }
}

#[cfg(test)]
mod tests {
    use super::HoldTimer;

    #[test]
    fn the_condition_must_hold_for_the_time_and_restarts_when_interrupted() {
        let mut held = HoldTimer::default();
        let steps: std::vec::Vec<_> = (0..5).map(|_| held.step::<4000>(true, 10)).collect();
        assert_eq!(steps, [false, false, false, true, true]);
        assert!(!held.step::<4000>(false, 10));
        assert!(!held.step::<4000>(true, 10));
        assert!(held.step::<4000>(true, 0), "a time of 0 has no delay");
    }
}
