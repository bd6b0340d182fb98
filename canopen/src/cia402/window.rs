//! A condition that has to hold for some time.

/// For how long a condition has held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Held {
    time_us: u32,
}

impl Held {
    /// Whether it has held for `time_ms` by now; one period counts from its beginning.
    #[cfg_attr(target_os = "none", inline(never))]
    pub fn step(&mut self, holds: bool, time_ms: u16, period_us: u32) -> bool {
        if !holds {
            self.time_us = 0;
            return false;
        }
        let reached = self.time_us >= u32::from(time_ms) * 1000;
        self.time_us = self.time_us.saturating_add(period_us);
        reached
    }
}

#[cfg(test)]
mod tests {
    use super::Held;

    #[test]
    fn it_holds_after_the_time_and_begins_anew() {
        let mut held = Held::default();
        let steps: std::vec::Vec<_> = (0..5).map(|_| held.step(true, 10, 4000)).collect();
        assert_eq!(steps, [false, false, false, true, true]);
        assert!(!held.step(false, 10, 4000));
        assert!(!held.step(true, 10, 4000));
        assert!(held.step(true, 0, 4000), "without a time at once");
    }
}
