//! Times that the services wait.

/// Counts down, us. At zero and below it is over; how far below tells how late it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Timer(i32);

impl Timer {
    /// The longest time there is: 35 min.
    pub const LONGEST_US: u32 = i32::MAX as u32;
    pub const OVER: Self = Self(0);

    /// Over after so many microseconds, or after the longest time.
    pub const fn us(time_us: u32) -> Self {
        if time_us > Self::LONGEST_US {
            Self(i32::MAX)
        } else {
            Self(time_us as i32)
        }
    }

    pub const fn ms(time_ms: u16) -> Self {
        Self(time_ms as i32 * 1000)
    }

    pub const fn hundreds_us(time_100us: u16) -> Self {
        Self(time_100us as i32 * 100)
    }

    /// Time passes.
    pub const fn pass(&mut self, elapsed: Self) {
        self.0 = self.0.saturating_sub(elapsed.0);
    }

    pub const fn is_over(self) -> bool {
        self.0 <= 0
    }

    /// Whether it was over some time ago already.
    pub const fn is_long_over(self) -> bool {
        self.0 < 0
    }

    /// Whether it is over. It begins again then: with the next point of a grid of `period`, or one period from now where
    /// more than one was missed.
    pub fn repeats(&mut self, period: Self) -> bool {
        let over = self.is_over();
        if over {
            self.0 += period.0;
            if self.is_over() {
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
    fn the_grid_does_not_drift_and_does_not_catch_up() {
        let after = |elapsed_us| {
            let mut timer = Timer::us(100);
            timer.pass(Timer::us(elapsed_us));
            (timer.repeats(Timer::us(10)), timer)
        };
        assert_eq!(after(99), (false, Timer::us(1)));
        assert_eq!(after(103), (true, Timer::us(7)));
        assert_eq!(after(137), (true, Timer::us(10)));
        assert_eq!(after(u32::MAX), (true, Timer::us(10)));
    }

    #[test]
    fn what_is_over_stays_so() {
        let mut timer = Timer::ms(u16::MAX);
        for _ in 0..3 {
            timer.pass(Timer::us(u32::MAX));
            assert!(timer.is_over());
        }
    }
}
