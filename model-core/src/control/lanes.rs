//! The control step of several actuators at once, bit for bit that of [`super::cascade`].
//!
//! Each quantity is an array with one element an actuator, and each operation a loop over them
//! without branches, of which the compiler makes vectors. Vectors multiply signed digits of 32
//! bits, as the board does. The tests compare every step with that of
//! [`CascadeState`](super::cascade::CascadeState).

#![allow(
    clippy::needless_range_loop,
    reason = "each loop is over an index of many arrays"
)]

use core::{array::from_fn, hint::cold_path};

use super::{
    arithmetic::Coefficient,
    cascade::Coefficients,
    encoder_word::COUNTS_PER_TURN,
    rate_loop::INTEGRATOR_END,
    shaft_tracker::COUNT_STEPS,
    units::{Angle, Rate},
};
use crate::time::CONTROL_RATE_HZ;

/// One element an actuator, in steps of 2^-32 of its unit.
type Steps<const N: usize> = [i64; N];

/// The state and the coefficients of `N` control steps.
///
/// The encoders are valid in every period and their angles within 32,000 deg, so that neither
/// missed periods nor the end of the angle's range occur.
#[derive(Debug, Clone)]
pub struct CascadeLanes<const N: usize> {
    gains: Gains<N>,
    state: State<N>,
}

#[derive(Debug, Clone)]
struct Gains<const N: usize> {
    /// 1, or -1 where the encoder is reversed.
    direction: [i64; N],
    filter: Factors<N>,
    position: Factors<N>,
    proportional: Factors<N>,
    integral: Factors<N>,
    anti_windup: Factors<N>,
    feed_forward: Factors<N>,
    /// Whether any actuator feeds forward.
    feeds_forward: bool,
    least_angle: Steps<N>,
    greatest_angle: Steps<N>,
    rate_down: Steps<N>,
    rate_up: Steps<N>,
    duty_limit: Steps<N>,
    duty_step: Steps<N>,
}

#[derive(Debug, Clone, Copy)]
struct State<const N: usize> {
    last: [i64; N],
    counts: [i64; N],
    rate: Steps<N>,
    integrator: Steps<N>,
    duty: Steps<N>,
}

/// The coefficients of one product, digit by digit.
#[derive(Debug, Clone)]
struct Factors<const N: usize> {
    whole: [i64; N],
    upper: [i64; N],
    lower: [i64; N],
    /// Whether all are below a half: their whole digits are zero.
    are_small: bool,
}

impl<const N: usize> Factors<N> {
    fn new(coefficient: impl Fn(usize) -> Coefficient) -> Self {
        let digits: [[i64; 3]; N] = from_fn(|lane| coefficient(lane).digits().map(i64::from));
        Self {
            whole: from_fn(|lane| digits[lane][0]),
            upper: from_fn(|lane| digits[lane][1]),
            lower: from_fn(|lane| digits[lane][2]),
            are_small: digits.iter().all(|[whole, ..]| *whole == 0),
        }
    }

    /// [`Coefficient::times`] of every actuator.
    #[inline(always)]
    fn times(&self, signals: &Steps<N>) -> Steps<N> {
        let mut products = [0; N];
        if N == 1 {
            // A single product has no use for vectors.
            for lane in 0..N {
                let digits = [self.whole[lane], self.upper[lane], self.lower[lane]];
                let coefficient = Coefficient::of_digits(digits.map(|digit| digit as i32));
                products[lane] = coefficient.times_word(signals[lane]);
            }
        } else if self.are_small {
            for lane in 0..N {
                let (low, high) = digits(signals[lane]);
                let (upper, lower) = (self.upper[lane], self.lower[lane]);
                let lowest = (product(low, lower) as u64 >> 32) as i64 ^ (1 << 31);
                let below = lowest + product(low, upper) + product(high, lower);
                products[lane] = (below >> 32) + product(high, upper);
            }
        } else {
            for lane in 0..N {
                let (low, high) = digits(signals[lane]);
                let (whole, upper, lower) = (self.whole[lane], self.upper[lane], self.lower[lane]);
                let lowest = (product(low, lower) as u64 >> 32) as i64 ^ (1 << 31);
                let below = lowest + product(low, upper) + product(high, lower);
                let bits = (below >> 32).wrapping_add(product(high, upper));
                let bits = bits.wrapping_add(product(low, whole));
                products[lane] = bits.wrapping_add(product(high, whole) << 32);
            }
        }
        products
    }
}

/// The digits of a number in base 2^32, the lower one first, each with a sign; above their 32 bits
/// stands anything.
#[inline(always)]
fn digits(signal: i64) -> (i64, i64) {
    // Half of the base more compensates for a negative lower digit.
    (signal, (signal.wrapping_add(1 << 31) as u64 >> 32) as i64)
}

/// The product of two numbers of 32 bits, which a vector multiplies in one instruction.
#[inline(always)]
fn product(a: i64, b: i64) -> i64 {
    i64::from(a as i32) * i64::from(b as i32)
}

/// `value` limited to `low..=high`: in several lanes without a branch. In a single one a branch,
/// which is nearly always predicted, is faster than a selection that the next step waits for.
#[inline(always)]
fn between<const N: usize>(value: i64, low: i64, high: i64) -> i64 {
    if N == 1 {
        if value > high {
            cold_path();
            return high;
        }
        if value < low {
            cold_path();
            return low;
        }
        return value;
    }
    let value = if value > high { high } else { value };
    if value < low { low } else { value }
}

/// The equivalent difference of counts that is nearest to zero.
#[inline(always)]
fn wrap(counts: i64) -> i64 {
    const TURN: i64 = COUNTS_PER_TURN as i64;
    ((counts + TURN / 2) & (TURN - 1)) - TURN / 2
}

impl<const N: usize> CascadeLanes<N> {
    /// Actuators at rest whose encoders stand at count 0.
    pub fn new(coefficients: &[Coefficients; N]) -> Self {
        let c = |lane: usize| &coefficients[lane];
        let steps = |of: fn(&Coefficients) -> i64| from_fn(|lane| of(c(lane)));
        let gains = Gains {
            direction: steps(|c| if c.mounting.reversed { -1 } else { 1 }),
            filter: Factors::new(|lane| c(lane).filter.coefficient()),
            position: Factors::new(|lane| c(lane).position.gain.coefficient()),
            proportional: Factors::new(|lane| c(lane).rate.proportional.coefficient()),
            integral: Factors::new(|lane| c(lane).rate.integral.coefficient()),
            anti_windup: Factors::new(|lane| c(lane).rate.anti_windup.coefficient()),
            feed_forward: Factors::new(|lane| c(lane).rate.feed_forward.coefficient()),
            feeds_forward: coefficients
                .iter()
                .any(|c| c.rate.feed_forward.coefficient() != Coefficient::default()),
            least_angle: steps(|c| c.position.min.to_bits()),
            greatest_angle: steps(|c| c.position.max.to_bits()),
            rate_down: steps(|c| -c.position.rate_down.to_bits()),
            rate_up: steps(|c| c.position.rate_up.to_bits()),
            duty_limit: steps(|c| c.rate.duty_limit.to_bits()),
            duty_step: steps(|c| c.rate.duty_step.to_bits()),
        };
        let zero = |lane: usize| i64::from(c(lane).mounting.zero.get());
        let state = State {
            last: [0; N],
            counts: from_fn(|lane| wrap(gains.direction[lane] * -zero(lane))),
            rate: [0; N],
            integrator: [0; N],
            duty: [0; N],
        };
        Self { gains, state }
    }

    /// The measured angle of an actuator, deg, and its estimated rate, deg/s.
    pub fn measured(&self, lane: usize) -> (Angle, Rate) {
        let angle = product(self.state.counts[lane], COUNT_STEPS);
        (
            Angle::from_bits(angle),
            Rate::from_bits(self.state.rate[lane]),
        )
    }

    /// Takes over the state of an actuator with the same coefficients.
    pub fn keep(&mut self, other: &Self, lane: usize) {
        let (state, other) = (&mut self.state, &other.state);
        state.last[lane] = other.last[lane];
        state.counts[lane] = other.counts[lane];
        state.rate[lane] = other.rate[lane];
        state.integrator[lane] = other.integrator[lane];
        state.duty[lane] = other.duty[lane];
    }

    /// One control period around an angle each: from the counts of the encoders, of which the low
    /// twelve bits matter, to the duties, %, in steps of 2^-32.
    #[inline(always)]
    pub fn step(&mut self, counts: &[i64; N], commands: &[Angle; N]) -> [i64; N] {
        let (gains, state) = (&self.gains, &mut self.state);
        let mut change = [0; N];
        let mut error = [0; N];
        for lane in 0..N {
            let count = counts[lane] & i64::from(COUNTS_PER_TURN - 1);
            let travelled = wrap(product(gains.direction[lane], count - state.last[lane]));
            state.last[lane] = count;
            state.counts[lane] += travelled;
            // 45/512 deg a period: the product of a number of 11 bits and one of 37.
            const COUNT_RATE: i64 = COUNT_STEPS * CONTROL_RATE_HZ as i64;
            const SHIFT: u32 = COUNT_RATE.trailing_zeros();
            let raw = product(travelled, COUNT_RATE >> SHIFT) << SHIFT;
            change[lane] = raw - state.rate[lane];
            let angle = product(state.counts[lane], COUNT_STEPS);
            let command = commands[lane].to_bits();
            let target = between::<N>(command, gains.least_angle[lane], gains.greatest_angle[lane]);
            error[lane] = target - angle;
        }
        let change = gains.filter.times(&change);
        let mut rate_command = gains.position.times(&error);
        for lane in 0..N {
            state.rate[lane] += change[lane];
            let rate = rate_command[lane];
            rate_command[lane] = between::<N>(rate, gains.rate_down[lane], gains.rate_up[lane]);
            error[lane] = rate_command[lane] - state.rate[lane];
        }
        let mut unlimited = gains.proportional.times(&error);
        let grown = gains.integral.times(&error);
        if gains.feeds_forward {
            let forward = gains.feed_forward.times(&rate_command);
            for lane in 0..N {
                unlimited[lane] += forward[lane];
            }
        }
        let mut excess = [0; N];
        for lane in 0..N {
            unlimited[lane] += state.integrator[lane];
            let (limit, step) = (gains.duty_limit[lane], gains.duty_step[lane]);
            let last = state.duty[lane];
            let limited = between::<N>(unlimited[lane], -limit, limit);
            // The last duty lies within the limit, which does not change.
            let duty = between::<N>(limited, last - step, last + step);
            state.duty[lane] = duty;
            excess[lane] = duty - unlimited[lane];
        }
        let excess = gains.anti_windup.times(&excess);
        for lane in 0..N {
            const END: i64 = (INTEGRATOR_END as i64) << 32;
            let integrator = state.integrator[lane] + grown[lane] + excess[lane];
            state.integrator[lane] = between::<N>(integrator, -END, END);
        }
        state.duty
    }
}
