//! Transport delay of whole ticks.

#[cfg(feature = "serde")]
mod serialization;

use crate::time::TICKS_PER_SECOND;

/// The longest transport delay, ticks: the end of its range, 1 s.
pub const LONGEST_DELAY: usize = TICKS_PER_SECOND as usize;

/// Memory for the values in transit: an array for delays of up to its length or, with the feature
/// `alloc`, a vector of the length of the delay.
pub trait Ring: AsRef<[f64]> + AsMut<[f64]> + Sized {
    /// Memory for this delay, zeroed; `None` if that is too long.
    fn for_delay(delay_ticks: usize) -> Option<Self>;
}

impl<const N: usize> Ring for [f64; N] {
    fn for_delay(delay_ticks: usize) -> Option<Self> {
        (delay_ticks <= N).then_some([0.0; N])
    }
}

#[cfg(feature = "alloc")]
impl Ring for alloc::vec::Vec<f64> {
    fn for_delay(delay_ticks: usize) -> Option<Self> {
        // Serialised bytes may ask for any length.
        (delay_ticks <= LONGEST_DELAY).then(|| alloc::vec![0.0; delay_ticks])
    }
}

/// The place of a transport delay in its memory, which is given to each call.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DelayCursor {
    delay_ticks: usize,
    oldest: usize,
    /// Whether the first value was received.
    started: bool,
}

impl DelayCursor {
    /// The start of a delay; `None` above [`LONGEST_DELAY`].
    pub fn try_new(delay_ticks: u64) -> Option<Self> {
        let delay_ticks = usize::try_from(delay_ticks).ok()?;
        (delay_ticks <= LONGEST_DELAY).then_some(Self {
            delay_ticks,
            oldest: 0,
            started: false,
        })
    }

    /// Values of its memory.
    pub fn len(&self) -> usize {
        self.delay_ticks
    }

    /// Whether it does not delay.
    pub fn is_empty(&self) -> bool {
        self.delay_ticks == 0
    }

    /// Discards the values in transit: the next one is again assumed to be the past.
    pub fn restart(&mut self) {
        (self.oldest, self.started) = (0, false);
    }

    /// Accepts the value of this tick and returns that of `delay_ticks` ago. Every value passes
    /// unchanged, including NaN.
    #[inline]
    pub fn shift(&mut self, memory: &mut [f64], value: f64) -> f64 {
        if self.delay_ticks == 0 {
            return value;
        }
        if !self.started {
            // In place: an array for the longest delay has 160 KB, too much to copy to the stack
            // or in every tick.
            memory.fill(value);
            self.started = true;
        }
        // `oldest < delay_ticks` always holds, which the memory has; `map_or` avoids the panic path
        // of an index.
        let delayed = memory
            .get_mut(self.oldest)
            .map_or(value, |place| core::mem::replace(place, value));
        self.oldest += 1;
        if self.oldest == self.delay_ticks {
            self.oldest = 0;
        }
        delayed
    }
}

/// Returns each value `delay_ticks` calls after it was passed in.
///
/// The paper has one such delay at the input of the actuator (section III: 0.0175 s, 350 ticks,
/// "because of the test setup"). Until the delay has elapsed the line returns its first value, as
/// if the command had been constant before.
#[derive(Debug, Clone, PartialEq)]
pub struct DelayLine<R> {
    cursor: DelayCursor,
    /// The values in transit, in the first `delay_ticks` elements.
    ring: R,
}

impl<R: Ring> DelayLine<R> {
    /// A line with a delay of `delay_ticks`; `None` if its memory is too small.
    ///
    /// ```
    /// use model_core::models::delay::DelayLine;
    ///
    /// let mut line = DelayLine::<[f64; 4]>::try_new(2).unwrap();
    /// assert_eq!([5.0, 6.0, 7.0, 8.0].map(|value| line.shift(value)), [5.0, 5.0, 5.0, 6.0]);
    /// assert!(DelayLine::<[f64; 4]>::try_new(5).is_none());
    /// ```
    pub fn try_new(delay_ticks: u64) -> Option<Self> {
        let cursor = DelayCursor::try_new(delay_ticks)?;
        Some(Self {
            ring: R::for_delay(cursor.len())?,
            cursor,
        })
    }

    /// As [`DelayCursor::shift`].
    #[inline]
    pub fn shift(&mut self, value: f64) -> f64 {
        self.cursor.shift(self.ring.as_mut(), value)
    }

    /// The place and the memory.
    pub fn parts(&mut self) -> (&mut DelayCursor, &mut [f64]) {
        (&mut self.cursor, self.ring.as_mut())
    }
}

#[cfg(test)]
mod tests {
    use super::DelayLine;
    use proptest::prelude::*;

    #[test]
    fn the_maximum_delay_is_the_capacity() {
        assert!(DelayLine::<[f64; 350]>::try_new(350).is_some());
        assert!(DelayLine::<[f64; 350]>::try_new(351).is_none());
        assert!(DelayLine::<[f64; 350]>::try_new(u64::MAX).is_none());
    }

    #[test]
    fn nan_and_infinity_pass_unchanged() {
        let mut line = DelayLine::<[f64; 1]>::try_new(1).unwrap();
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
            let mut line = DelayLine::<[f64; 8]>::try_new(delay as u64).unwrap();
            for (i, value) in values.iter().enumerate() {
                prop_assert_eq!(line.shift(*value), values[i.saturating_sub(delay)]);
            }
        }
    }
}
