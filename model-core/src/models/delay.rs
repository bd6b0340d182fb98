//! Transport delay of whole ticks, without a heap.

#[cfg(feature = "serde")]
mod serialization;

/// Returns each value `delay_ticks` calls after it was passed in, for up to `N` ticks.
///
/// The paper has one such delay at the input of the actuator (section III: 0.0175 s, 350 ticks,
/// "because of the test setup"). Until the delay has elapsed the line returns its first value, as
/// if the command had been constant before.
#[derive(Debug, Clone, PartialEq)]
pub struct DelayLine<const N: usize> {
    delay_ticks: usize,
    /// The values in transit, in the first `delay_ticks` elements.
    ring: [f64; N],
    oldest: usize,
    /// Whether the first value was received.
    started: bool,
}

impl<const N: usize> DelayLine<N> {
    /// A line with a delay of `delay_ticks`; `None` if that is more than `N`.
    ///
    /// ```
    /// use model_core::models::delay::DelayLine;
    ///
    /// let mut line = DelayLine::<4>::try_new(2).unwrap();
    /// assert_eq!([5.0, 6.0, 7.0, 8.0].map(|value| line.shift(value)), [5.0, 5.0, 5.0, 6.0]);
    /// assert!(DelayLine::<4>::try_new(5).is_none());
    /// ```
    pub fn try_new(delay_ticks: u64) -> Option<Self> {
        let delay_ticks = usize::try_from(delay_ticks).ok().filter(|d| *d <= N)?;
        Some(Self {
            delay_ticks,
            ring: [0.0; N],
            oldest: 0,
            started: false,
        })
    }

    /// Accepts the value of this tick and returns that of `delay_ticks` ago. Every value passes
    /// unchanged, including NaN.
    #[inline]
    pub fn shift(&mut self, value: f64) -> f64 {
        if self.delay_ticks == 0 {
            return value;
        }
        if !self.started {
            // In place: the actuator's line has 160 KB, too much to copy to the stack or in every
            // tick.
            self.ring.fill(value);
            self.started = true;
        }
        // `oldest < delay_ticks <= N` always holds; `map_or` avoids the panic path of an index.
        let delayed = self
            .ring
            .get_mut(self.oldest)
            .map_or(value, |place| core::mem::replace(place, value));
        self.oldest += 1;
        if self.oldest == self.delay_ticks {
            self.oldest = 0;
        }
        delayed
    }
}

#[cfg(test)]
mod tests {
    use super::DelayLine;
    use proptest::prelude::*;

    #[test]
    fn the_maximum_delay_is_the_capacity() {
        assert!(DelayLine::<350>::try_new(350).is_some());
        assert!(DelayLine::<350>::try_new(351).is_none());
        assert!(DelayLine::<350>::try_new(u64::MAX).is_none());
    }

    #[test]
    fn nan_and_infinity_pass_unchanged() {
        let mut line = DelayLine::<1>::try_new(1).unwrap();
        assert!(line.shift(f64::NAN).is_nan());
        assert!(line.shift(f64::INFINITY).is_nan());
        assert_eq!(line.shift(1.0), f64::INFINITY);
        assert_eq!(line.shift(2.0), 1.0);
    }

    proptest! {
        #[test]
        fn each_value_is_returned_after_the_delay_and_the_first_value_before(
            delay in 0_usize..=8,
            values in proptest::collection::vec(-1e3..1e3, 1..40),
        ) {
            let mut line = DelayLine::<8>::try_new(delay as u64).unwrap();
            for (i, value) in values.iter().enumerate() {
                prop_assert_eq!(line.shift(*value), values[i.saturating_sub(delay)]);
            }
        }
    }
}
