//! The end of a stop: once the shaft has stood for 20 ms, or when `quick_stop_ms` has elapsed.

use crate::{parameters::StopSettings, timing::periods};

/// Control periods for which the shaft has to stand: 20 ms.
const STANDING_PERIODS: u8 = periods(20) as u8;

/// How long a stop lasts, and how long the shaft has stood.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct StopProgress {
    periods: u16,
    standing: u8,
}

impl StopProgress {
    /// One control period; whether the shaft stands, if that is known.
    pub fn next(&mut self, stands: Option<bool>) {
        self.periods = self.periods.saturating_add(1);
        self.standing = match stands {
            Some(true) => self.standing.saturating_add(1),
            Some(false) => 0,
            None => self.standing,
        };
    }

    /// That of another kind of stop that continues this one: the time that has elapsed counts, but
    /// not what this one has measured.
    pub fn continued(self) -> Self {
        Self {
            standing: 0,
            ..self
        }
    }

    /// Whether it has lasted for as long as the shaft has to stand.
    pub fn has_settled(&self) -> bool {
        self.periods >= u16::from(STANDING_PERIODS)
    }

    /// Whether the stop has ended.
    pub fn is_over(&self, settings: &StopSettings) -> bool {
        self.standing >= STANDING_PERIODS || self.periods >= periods(settings.quick_stop_ms)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Control periods to the end of a stop.
    fn periods_left(mut progress: StopProgress, stands: Option<bool>) -> u32 {
        let mut periods = 0;
        while !progress.is_over(&StopSettings::DEFAULT) {
            progress.next(stands);
            periods += 1;
        }
        periods
    }

    #[test]
    fn a_stop_ends_20_ms_after_the_shaft_stands_or_after_the_longest_time() {
        let progress = StopProgress::default();
        assert_eq!(periods_left(progress, Some(true)), 5);
        assert_eq!(periods_left(progress, Some(false)), 125);
        assert_eq!(periods_left(progress, None), 125);
    }

    #[test]
    fn an_unknown_rate_neither_counts_as_standing_nor_as_turning() {
        let mut progress = StopProgress::default();
        for stands in [Some(true), Some(true), None, None] {
            progress.next(stands);
        }
        assert_eq!(periods_left(progress, Some(true)), 3);
    }

    #[test]
    fn a_continued_stop_keeps_its_time_and_measures_the_standstill_anew() {
        let mut progress = StopProgress::default();
        for period in 0..100 {
            progress.next(Some(period >= 96));
        }
        assert_eq!(periods_left(progress, Some(true)), 1);
        assert_eq!(periods_left(progress.continued(), Some(true)), 5);
        assert_eq!(periods_left(progress.continued(), Some(false)), 25);
    }
}
