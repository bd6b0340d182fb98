//! Access to the coefficients by row of
//! [`ControlParameters`](crate::control::parameters::ControlParameters), as a bus and a flash
//! memory need it.
//!
//! Values are in single precision and in the units and ranges of the table. A written value reads
//! back unchanged except where the coefficient is narrower: the encoder's zero is a whole count,
//! and a limit beyond the widest one reads as the widest.

use super::{
    super::{scaled::Scaled, shaft_tracker::COUNT_STEPS},
    *,
};
use crate::parameter::Parameters;

const POSITION_GAIN: usize = ControlParameters::row("position_gain");
const PROPORTIONAL_GAIN: usize = ControlParameters::row("proportional_gain");
const INTEGRAL_GAIN: usize = ControlParameters::row("integral_gain");
const ANTI_WINDUP_GAIN: usize = ControlParameters::row("anti_windup_gain");
const FEED_FORWARD_GAIN: usize = ControlParameters::row("feed_forward_gain");
const RATE_FILTER: usize = ControlParameters::row("rate_filter");
const POSITION_MIN: usize = ControlParameters::row("position_min_deg");
const POSITION_MAX: usize = ControlParameters::row("position_max_deg");
const RATE_LIMIT_UP: usize = ControlParameters::row("rate_command_limit_up_deg_s");
const RATE_LIMIT_DOWN: usize = ControlParameters::row("rate_command_limit_down_deg_s");
const DUTY_LIMIT: usize = ControlParameters::row("duty_limit_pct");
const DUTY_SLEW: usize = ControlParameters::row("duty_slew_pct_s");
const ENCODER_ZERO: usize = ControlParameters::row("encoder_zero_deg");
const ENCODER_DIRECTION: usize = ControlParameters::row("encoder_direction");

/// Number of parameters.
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
    /// The parameter of a row; `None` beyond the last row.
    ///
    /// ```
    /// use model_core::control::{cascade::Coefficients, parameters::ControlParameters};
    ///
    /// let coefficients = Coefficients::try_new(&ControlParameters::DEFAULT).unwrap();
    /// assert_eq!([0, 2, 12].map(|row| coefficients.get(row)), [Some(8.0), Some(10.0), Some(0.0)]);
    /// assert_eq!(coefficients.get(14), None);
    /// ```
    pub fn get(&self, row: usize) -> Option<f32> {
        let (p, r) = (&self.position, &self.rate);
        let coefficient = Scaled::of_coefficient;
        let value = match row {
            POSITION_GAIN => coefficient(p.gain.coefficient()),
            PROPORTIONAL_GAIN => coefficient(r.proportional.coefficient()),
            INTEGRAL_GAIN => coefficient(r.integral.coefficient()),
            ANTI_WINDUP_GAIN => coefficient(r.anti_windup.coefficient()),
            FEED_FORWARD_GAIN => coefficient(r.feed_forward.coefficient()),
            RATE_FILTER => coefficient(self.filter.coefficient()),
            POSITION_MIN => Scaled::of_signal(p.min),
            POSITION_MAX => Scaled::of_signal(p.max),
            RATE_LIMIT_UP => Scaled::of_signal(p.rate_up),
            RATE_LIMIT_DOWN => Scaled::of_signal(p.rate_down),
            DUTY_LIMIT => Scaled::of_signal(r.duty_limit),
            DUTY_SLEW => Scaled::of_signal(r.duty_step),
            ENCODER_ZERO => Scaled::of_signal(self.mounting.zero_deg()),
            ENCODER_DIRECTION => Scaled::of_signal(if self.mounting.reversed {
                -Angle::ONE
            } else {
                Angle::ONE
            }),
            _ => return None,
        };
        let value = if is_per_period(row) {
            value.per_second()
        } else {
            value
        };
        Some(value.f32())
    }

    /// Sets the parameter of a row. Returns `false` and changes nothing if the value is NaN, out of
    /// its range or in conflict with another parameter.
    ///
    /// Writing the value that is read changes nothing, so that defaults of double precision survive
    /// a round trip through single precision.
    ///
    /// ```
    /// use model_core::control::{cascade::Coefficients, parameters::ControlParameters};
    ///
    /// let mut coefficients = Coefficients::try_new(&ControlParameters::DEFAULT).unwrap();
    /// assert!(coefficients.set(0, 12.5));
    /// assert!(!coefficients.set(0, 501.0));
    /// assert_eq!(coefficients.get(0), Some(12.5));
    /// ```
    pub fn set(&mut self, row: usize, value: f32) -> bool {
        if self.get(row) == Some(value) {
            return true;
        }
        let mut changed = *self;
        let is_taken =
            is_in_range(row, value) && changed.assign(row, value) && changed.is_ordered();
        if is_taken {
            *self = changed;
        }
        is_taken
    }

    fn assign(&mut self, row: usize, value: f32) -> bool {
        let (p, r) = (&mut self.position, &mut self.rate);
        let exactly = Scaled::of_f32(value);
        let exactly = if is_per_period(row) {
            exactly.per_period()
        } else {
            exactly
        };
        match row {
            POSITION_GAIN => p.gain = Gain::of(exactly.coefficient()),
            PROPORTIONAL_GAIN => r.proportional = Gain::of(exactly.coefficient()),
            INTEGRAL_GAIN => r.integral = Gain::of(exactly.coefficient()),
            ANTI_WINDUP_GAIN => r.anti_windup = Gain::of(exactly.coefficient()),
            FEED_FORWARD_GAIN => r.feed_forward = Gain::of(exactly.coefficient()),
            RATE_FILTER => self.filter = Gain::of(exactly.coefficient()),
            POSITION_MIN => p.min = exactly.signal(),
            POSITION_MAX => p.max = exactly.signal(),
            RATE_LIMIT_UP => p.rate_up = exactly.signal::<Rate>().at_most(RATE_END),
            RATE_LIMIT_DOWN => p.rate_down = exactly.signal::<Rate>().at_most(RATE_END),
            DUTY_LIMIT => r.duty_limit = exactly.signal(),
            DUTY_SLEW => r.duty_step = exactly.signal::<Percent>().at_most(DUTY_STEP_END),
            ENCODER_ZERO => self.mounting.zero = nearest_count(exactly.signal()),
            ENCODER_DIRECTION => match exactly.signal::<Angle>() {
                direction if direction == Angle::ONE => self.mounting.reversed = false,
                direction if direction == -Angle::ONE => self.mounting.reversed = true,
                _ => return false,
            },
            _ => return false,
        }
        true
    }

    fn is_ordered(&self) -> bool {
        self.position.min <= self.position.max
    }
}

/// Whether the parameter is per second and the coefficient per control period.
fn is_per_period(row: usize) -> bool {
    matches!(row, INTEGRAL_GAIN | ANTI_WINDUP_GAIN | DUTY_SLEW)
}

fn is_in_range(row: usize, value: f32) -> bool {
    // Written so that NaN fails.
    RANGES
        .get(row)
        .is_some_and(|&(min, max)| value >= min && value <= max)
}

/// The count nearest to an angle within 180 deg.
fn nearest_count(angle: Angle) -> EncoderCount {
    // COUNT_STEPS are 45 * 2^23, and 180 * 2^32 over 2^23 below 2^17: a division of 32 bits.
    let odd = (COUNT_STEPS >> COUNT_STEPS.trailing_zeros()) as u32;
    let steps = angle.to_bits().unsigned_abs() + COUNT_STEPS as u64 / 2;
    let counts = ((steps >> COUNT_STEPS.trailing_zeros()) as u32 / odd) as u16;
    EncoderCount::new(if angle < Angle::ZERO {
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

    /// A row and a value for it.
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
        fn coefficients_of_single_precision_equal_those_of_double_precision(changes in proptest::collection::vec(change(), 1..20)) {
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
    fn writing_a_default_as_it_reads_keeps_every_bit() {
        let mut coefficients = default();
        assert!(coefficients.set(5, 0.4));
        assert_eq!(coefficients, default());
        // 0.4 of single precision is another number.
        assert!(coefficients.set(5, 0.5) && coefficients.set(5, 0.4));
        assert_ne!(coefficients, default());
        assert_eq!(coefficients.get(5), default().get(5));
    }

    #[test]
    fn the_neighbours_of_a_range_are_refused() {
        for (row, &(min, max)) in RANGES.iter().enumerate() {
            // Without a limit an infinite one is allowed.
            let neighbours = [(min, min.next_down()), (max, max.next_up())];
            for (_, value) in neighbours.iter().filter(|(end, _)| end.is_finite()) {
                let mut coefficients = default();
                assert!(!coefficients.set(row, *value), "row {row}: {value}");
                assert_eq!(coefficients, default());
            }
        }
    }

    #[test]
    fn crossed_limits_and_an_invalid_direction_are_refused() {
        let mut coefficients = default();
        assert!(coefficients.set(7, 10.0));
        assert!(!coefficients.set(6, 11.0));
        assert!(!coefficients.set(13, 0.5));
        assert!(!coefficients.set(0, f32::NAN));
        assert!(!coefficients.set(14, 0.0));
        assert_eq!(coefficients.get(6), Some(-32768.0));
    }
}
