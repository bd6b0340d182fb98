//! The coefficients one by one, as a bus sets them, and as words, as a flash memory keeps them.
//!
//! Numbers, units and ranges are those of the rows of
//! [`ControlParameters`](crate::control::parameters::ControlParameters). Values are of single
//! precision; what is written comes back unchanged but where the coefficient itself is narrower:
//! the encoder's zero is a whole count, and limits end where they no longer limit.

use super::{
    super::{scaled::Scaled, shaft_angle::COUNT_STEPS},
    *,
};
use crate::parameter::Parameters;

/// How many parameters there are.
const ROWS: usize = ControlParameters::TABLE.len();

/// Their ranges in single precision.
const RANGES: [(f32, f32); ROWS] = {
    let mut ranges = [(0.0, 0.0); ROWS];
    let mut row = 0;
    while row < ROWS {
        let Parameter { min, max, .. } = ControlParameters::TABLE[row];
        ranges[row] = (min as f32, max as f32);
        row += 1;
    }
    ranges
};

/// Words of [`Coefficients::words`].
pub const COEFFICIENT_WORDS: usize = 21;

impl Coefficients {
    /// The parameter of row `number`; `None` beyond the last one.
    ///
    /// ```
    /// use model_core::control::{cascade::Coefficients, parameters::ControlParameters};
    ///
    /// let coefficients = Coefficients::try_new(&ControlParameters::DEFAULT).unwrap();
    /// assert_eq!([0, 2, 12].map(|row| coefficients.get(row)), [Some(8.0), Some(10.0), Some(0.0)]);
    /// assert_eq!(coefficients.get(14), None);
    /// ```
    pub fn get(&self, number: usize) -> Option<f32> {
        let (p, r) = (&self.position, &self.rate);
        let coefficient = Scaled::of_coefficient;
        let signal = Scaled::of_signal;
        Some(match number {
            0 => coefficient(p.gain).f32(),
            1 => coefficient(r.proportional).f32(),
            2 => coefficient(r.integral).per_second().f32(),
            3 => coefficient(r.anti_windup).per_second().f32(),
            4 => coefficient(r.feed_forward).f32(),
            5 => coefficient(self.filter).f32(),
            6 => signal(p.min).f32(),
            7 => signal(p.max).f32(),
            8 => signal(p.rate_up).f32(),
            9 => signal(p.rate_down).f32(),
            10 => signal(r.duty_limit).f32(),
            11 => signal(r.duty_step).per_second().f32(),
            12 => signal(self.mounting.zero_deg()).f32(),
            13 if self.mounting.reversed => -1.0,
            13 => 1.0,
            _ => return None,
        })
    }

    /// Sets the parameter of row `number`; `false`, and nothing is changed, where it is NaN, out of
    /// its range or at odds with another.
    ///
    /// ```
    /// use model_core::control::{cascade::Coefficients, parameters::ControlParameters};
    ///
    /// let mut coefficients = Coefficients::try_new(&ControlParameters::DEFAULT).unwrap();
    /// assert!(coefficients.set(0, 12.5));
    /// assert!(!coefficients.set(0, 501.0));
    /// assert_eq!(coefficients.get(0), Some(12.5));
    /// ```
    pub fn set(&mut self, number: usize, value: f32) -> bool {
        let mut changed = *self;
        let is_taken =
            is_in_range(number, value) && changed.assign(number, value) && changed.is_ordered();
        if is_taken {
            *self = changed;
        }
        is_taken
    }

    fn assign(&mut self, number: usize, value: f32) -> bool {
        let (p, r) = (&mut self.position, &mut self.rate);
        let number_of = Scaled::of_f32(value);
        match number {
            0 => p.gain = number_of.coefficient(),
            1 => r.proportional = number_of.coefficient(),
            2 => r.integral = number_of.per_period().coefficient(),
            3 => r.anti_windup = number_of.per_period().coefficient(),
            4 => r.feed_forward = number_of.coefficient(),
            5 => self.filter = number_of.coefficient(),
            6 => p.min = number_of.signal(),
            7 => p.max = number_of.signal(),
            8 => p.rate_up = least(number_of.signal(), WIDEST_RATE),
            9 => p.rate_down = least(number_of.signal(), WIDEST_RATE),
            10 => r.duty_limit = number_of.signal(),
            11 => r.duty_step = least(number_of.per_period().signal(), WIDEST_STEP),
            12 => self.mounting.zero = nearest_count(number_of.signal()),
            13 if value == 1.0 || value == -1.0 => self.mounting.reversed = value < 0.0,
            _ => return false,
        }
        true
    }

    fn is_ordered(&self) -> bool {
        self.position.min <= self.position.max
    }

    /// Everything in a fixed layout: six mantissas, their six shifts, six signals of two words each,
    /// the lower one first, and the encoder's zero with its sense in bit 16.
    pub fn words(&self) -> [u32; COEFFICIENT_WORDS] {
        let (p, r) = (&self.position, &self.rate);
        let parts = [
            p.gain,
            r.proportional,
            r.integral,
            r.anti_windup,
            r.feed_forward,
            self.filter,
        ]
        .map(Coefficient::parts);
        let [a, b, c, d, e, f] = parts.map(|(mantissa, _)| mantissa as u32);
        let [s, t, u, v, w, x] = parts.map(|(_, shift)| shift);
        let halves = |signal: Angle| {
            let bits = signal.to_bits() as u64;
            [bits as u32, (bits >> 32) as u32]
        };
        let [g, h] = halves(p.min);
        let [i, j] = halves(p.max);
        let [k, l] = halves(p.rate_up);
        let [m, n] = halves(p.rate_down);
        let [o, q] = halves(r.duty_limit);
        let [y, z] = halves(r.duty_step);
        let mounting =
            u32::from(self.mounting.zero.get()) | u32::from(self.mounting.reversed) << 16;
        let shifts = [
            u32::from_le_bytes([s, t, u, v]),
            u32::from_le_bytes([w, x, 0, 0]),
        ];
        [
            a, b, c, d, e, f, shifts[0], shifts[1], g, h, i, j, k, l, m, n, o, q, y, z, mounting,
        ]
    }

    /// What [`Coefficients::words`] gave; `None` where a value is out of its range or at odds with
    /// another.
    pub fn from_words(words: &[u32; COEFFICIENT_WORDS]) -> Option<Self> {
        let &[
            a,
            b,
            c,
            d,
            e,
            f,
            shifts,
            more_shifts,
            g,
            h,
            i,
            j,
            k,
            l,
            m,
            n,
            o,
            q,
            y,
            z,
            mounting,
        ] = words;
        let [s, t, u, v] = shifts.to_le_bytes();
        let [w, x, ..] = more_shifts.to_le_bytes();
        let coefficient =
            |mantissa: u32, shift: u8| Coefficient::from_parts(mantissa as i32, shift.min(62));
        let signal =
            |low: u32, high: u32| Angle::from_bits((u64::from(low) | u64::from(high) << 32) as i64);
        let coefficients = Self {
            mounting: Mounting {
                zero: EncoderCount::new(mounting as u16),
                reversed: mounting >> 16 & 1 == 1,
            },
            filter: coefficient(f, x),
            position: PositionLoop {
                gain: coefficient(a, s),
                min: signal(g, h),
                max: signal(i, j),
                rate_up: least(signal(k, l), WIDEST_RATE),
                rate_down: least(signal(m, n), WIDEST_RATE),
            },
            rate: RateLoop {
                proportional: coefficient(b, t),
                integral: coefficient(c, u),
                anti_windup: coefficient(d, v),
                feed_forward: coefficient(e, w),
                duty_limit: signal(o, q),
                duty_step: least(signal(y, z), WIDEST_STEP),
            },
        };
        let is_possible = coefficients.is_ordered()
            && (0..ROWS).all(|row| coefficients.get(row).is_some_and(|v| is_in_range(row, v)));
        is_possible.then_some(coefficients)
    }
}

fn is_in_range(number: usize, value: f32) -> bool {
    // Written so that NaN fails.
    RANGES
        .get(number)
        .is_some_and(|&(min, max)| value >= min && value <= max)
}

/// The count that lies nearest to an angle within 180 deg.
fn nearest_count(angle: Angle) -> EncoderCount {
    let bits = angle.to_bits();
    let half = if bits < 0 {
        -COUNT_STEPS / 2
    } else {
        COUNT_STEPS / 2
    };
    EncoderCount::new(((bits + half) / COUNT_STEPS) as u16)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn default() -> Coefficients {
        Coefficients::try_new(&ControlParameters::DEFAULT).unwrap()
    }

    /// A row and a value of it.
    fn change() -> impl Strategy<Value = (usize, f32)> {
        (0..ROWS, 0f32..=1.0).prop_map(|(row, share)| {
            let (min, max) = RANGES[row];
            let max = max.min(1e5);
            let value = min + share * (max - min);
            (row, if row == 13 { value.signum() } else { value })
        })
    }

    proptest! {
        #[test]
        fn what_a_bus_sets_is_what_double_precision_makes_of_it(changes in proptest::collection::vec(change(), 1..20)) {
            let (mut parameters, mut coefficients) = (ControlParameters::DEFAULT, default());
            for (row, value) in changes {
                let mut changed = parameters;
                *changed.get_mut(row).unwrap() = f64::from(value);
                let expected = Coefficients::try_new(&changed);
                prop_assert_eq!(coefficients.set(row, value), expected.is_ok());
                if let Ok(expected) = expected {
                    parameters = changed;
                    for other in 0..ROWS {
                        let (a, b) = (coefficients.get(other).unwrap(), expected.get(other).unwrap());
                        prop_assert_eq!(a.to_bits(), b.to_bits(), "row {}", other);
                    }
                    if !matches!(row, 2 | 3 | 11) {
                        prop_assert_eq!(coefficients.get(row).unwrap().to_bits(), expected.get(row).unwrap().to_bits());
                    }
                }
            }
            prop_assert_eq!(Coefficients::from_words(&coefficients.words()), Some(coefficients));
        }

        #[test]
        fn no_word_makes_coefficients_beyond_the_ranges(
            index in 0..COEFFICIENT_WORDS, word: u32, words in proptest::array::uniform21(any::<u32>())
        ) {
            let _ = Coefficients::from_words(&words);
            let mut words = default().words();
            words[index] = word;
            if let Some(coefficients) = Coefficients::from_words(&words) {
                for row in 0..ROWS {
                    prop_assert!(is_in_range(row, coefficients.get(row).unwrap()));
                }
            }
        }
    }

    #[test]
    fn the_defaults_come_back_from_their_words_to_the_last_bit() {
        assert_eq!(
            Coefficients::from_words(&default().words()),
            Some(default())
        );
    }

    #[test]
    fn crossed_limits_and_a_sense_that_is_none_are_refused() {
        let mut coefficients = default();
        assert!(coefficients.set(7, 10.0));
        assert!(!coefficients.set(6, 11.0));
        assert!(!coefficients.set(13, 0.5));
        assert!(!coefficients.set(0, f32::NAN));
        assert!(!coefficients.set(14, 0.0));
        assert_eq!(coefficients.get(6), Some(-32768.0));
    }
}
