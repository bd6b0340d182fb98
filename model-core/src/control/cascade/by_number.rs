//! The coefficients one by one, as a bus sets them and a flash memory keeps them.
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
        let value = match number {
            0 => coefficient(p.gain),
            1 => coefficient(r.proportional),
            2 => coefficient(r.integral),
            3 => coefficient(r.anti_windup),
            4 => coefficient(r.feed_forward),
            5 => coefficient(self.filter),
            6 => signal(p.min),
            7 => signal(p.max),
            8 => signal(p.rate_up),
            9 => signal(p.rate_down),
            10 => signal(r.duty_limit),
            11 => signal(r.duty_step),
            12 => signal(self.mounting.zero_deg()),
            13 => signal(if self.mounting.reversed {
                -Angle::ONE
            } else {
                Angle::ONE
            }),
            _ => return None,
        };
        let value = if is_per_period(number) {
            value.per_second()
        } else {
            value
        };
        Some(value.f32())
    }

    /// Sets the parameter of row `number`; `false`, and nothing is changed, where it is NaN, out of
    /// its range or at odds with another.
    ///
    /// What is written as it reads changes nothing, so that defaults of double precision survive the
    /// way through single precision.
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
        if self.get(number) == Some(value) {
            return true;
        }
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
        let exactly = Scaled::of_f32(value);
        let exactly = if is_per_period(number) {
            exactly.per_period()
        } else {
            exactly
        };
        let coefficient = match number {
            0 => &mut p.gain,
            1 => &mut r.proportional,
            2 => &mut r.integral,
            3 => &mut r.anti_windup,
            4 => &mut r.feed_forward,
            5 => &mut self.filter,
            _ => return self.assign_signal(number, exactly.signal()),
        };
        *coefficient = exactly.coefficient();
        true
    }

    fn assign_signal(&mut self, number: usize, value: Angle) -> bool {
        let (p, r) = (&mut self.position, &mut self.rate);
        let (signal, greatest) = match number {
            6 => (&mut p.min, Angle::MAX),
            7 => (&mut p.max, Angle::MAX),
            8 => (&mut p.rate_up, WIDEST_RATE),
            9 => (&mut p.rate_down, WIDEST_RATE),
            10 => (&mut r.duty_limit, Angle::MAX),
            11 => (&mut r.duty_step, WIDEST_STEP),
            12 => {
                self.mounting.zero = nearest_count(value);
                return true;
            }
            13 if value == 1 || value == -1 => {
                self.mounting.reversed = value < 0;
                return true;
            }
            _ => return false,
        };
        *signal = least(value, greatest);
        true
    }

    fn is_ordered(&self) -> bool {
        self.position.min <= self.position.max
    }
}

/// Whether a bus says per second what the coefficient is per control period.
fn is_per_period(number: usize) -> bool {
    matches!(number, 2 | 3 | 11)
}

fn is_in_range(number: usize, value: f32) -> bool {
    // Written so that NaN fails.
    RANGES
        .get(number)
        .is_some_and(|&(min, max)| value >= min && value <= max)
}

/// The count that lies nearest to an angle within 180 deg.
fn nearest_count(angle: Angle) -> EncoderCount {
    // COUNT_STEPS are 45 * 2^23, and 180 * 2^32 over 2^23 below 2^17: a division of 32 bits.
    let odd = (COUNT_STEPS >> COUNT_STEPS.trailing_zeros()) as u32;
    let steps = angle.to_bits().unsigned_abs() + COUNT_STEPS as u64 / 2;
    let counts = ((steps >> COUNT_STEPS.trailing_zeros()) as u32 / odd) as u16;
    EncoderCount::new(if angle < 0 {
        counts.wrapping_neg()
    } else {
        counts
    })
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
            let mut again = default();
            for row in 0..ROWS {
                prop_assert!(again.set(row, coefficients.get(row).unwrap()), "row {}", row);
            }
            prop_assert_eq!(again, coefficients);
        }

        #[test]
        fn no_bits_make_coefficients_beyond_the_ranges(row in 0..ROWS, bits: u32) {
            let mut coefficients = default();
            if coefficients.set(row, f32::from_bits(bits)) {
                for row in 0..ROWS {
                    prop_assert!(is_in_range(row, coefficients.get(row).unwrap()));
                }
            } else {
                prop_assert_eq!(coefficients, default());
            }
        }
    }

    #[test]
    fn defaults_that_are_written_as_they_read_stay_to_the_last_bit() {
        let mut coefficients = default();
        assert!(coefficients.set(5, 0.4));
        assert_eq!(coefficients, default());
        // 0.4 of single precision is another number.
        assert!(coefficients.set(5, 0.5) && coefficients.set(5, 0.4));
        assert_ne!(coefficients, default());
        assert_eq!(coefficients.get(5), default().get(5));
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
