//! Timer of the services.

/// Down-counter in microseconds. It has expired at zero and below; a negative value is the time
/// since expiry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Timer(i32);

impl Timer {
    /// Longest time, 35 min.
    pub const LONGEST_US: u32 = i32::MAX as u32;
    pub const EXPIRED: Self = Self(0);

    /// Expires after `time_us`, or after the longest time.
    pub const fn from_us(time_us: u32) -> Self {
        if time_us > Self::LONGEST_US {
            Self(i32::MAX)
        } else {
            Self(time_us as i32)
        }
    }

    pub const fn from_ms(time_ms: u16) -> Self {
        Self(time_ms as i32 * 1000)
    }

    pub const fn from_100us(time_100us: u16) -> Self {
        Self(time_100us as i32 * 100)
    }

    /// Advances the timer.
    pub const fn advance(&mut self, elapsed: Self) {
        self.0 = self.0.saturating_sub(elapsed.0);
    }

    pub const fn is_expired(self) -> bool {
        self.0 <= 0
    }

    /// Whether it expired before the present instant.
    pub const fn is_overdue(self) -> bool {
        self.0 < 0
    }

    /// Returns whether it has expired, and if so restarts it on the grid of `period`, or one period
    /// from now if more than one period was missed.
    pub fn restart_if_expired(&mut self, period: Self) -> bool {
        let over = self.is_expired();
        if over {
            self.0 += period.0;
            if self.is_expired() {
                *self = period;
            }
        }
        over
    }
}

#[cfg(test)]
mod tests {
    use super::Timer;

    #[test]
    fn a_periodic_timer_neither_drifts_nor_catches_up_missed_periods() {
        let after = |elapsed_us| {
            let mut timer = Timer::from_us(100);
            timer.advance(Timer::from_us(elapsed_us));
            (timer.restart_if_expired(Timer::from_us(10)), timer)
        };
        assert_eq!(after(99), (false, Timer::from_us(1)));
        assert_eq!(after(103), (true, Timer::from_us(7)));
        assert_eq!(after(137), (true, Timer::from_us(10)));
        assert_eq!(after(u32::MAX), (true, Timer::from_us(10)));
    }

    #[test]
    fn an_expired_timer_remains_expired() {
        let mut timer = Timer::from_ms(u16::MAX);
        for _ in 0..3 {
            timer.advance(Timer::from_us(u32::MAX));
            assert!(timer.is_expired());
        }
    }
}
