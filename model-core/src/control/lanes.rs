//! The control step of several actuators at once, composed of the parts of [`super::cascade`].
//!
//! Each quantity is an array with one element an actuator. A loop takes the quantities of an
//! actuator from them, computes a part of its step and stores what has changed; of this the
//! compiler makes vectors. The tests compare every step with that of
//! [`CascadeState`](super::cascade::CascadeState).

use core::array::from_fn;

use super::{
    arithmetic::{Coefficient, Gain},
    cascade::Coefficients,
    encoder_word::EncoderCount,
    position_loop::PositionLoop,
    rate_estimate::RateEstimate,
    rate_loop::{RateLoop, RateLoopState},
    shaft_tracker::{Mounting, ShaftTracker},
    units::{Angle, Percent, Quantity, Rate},
};

/// The state and the coefficients of `N` control steps.
///
/// The encoders are valid in every period.
#[derive(Debug, Clone)]
pub struct CascadeLanes<const N: usize> {
    gains: Gains<N>,
    state: State<N>,
}

#[derive(Debug, Clone)]
struct Gains<const N: usize> {
    reversed: [bool; N],
    filter: Factors<N>,
    position: Factors<N>,
    min: [Angle; N],
    max: [Angle; N],
    rate_down: [Rate; N],
    rate_up: [Rate; N],
    proportional: Factors<N>,
    integral: Factors<N>,
    anti_windup: Factors<N>,
    feed_forward: Factors<N>,
    /// Whether any actuator feeds forward.
    feeds_forward: bool,
    duty_limit: [Percent; N],
    duty_step: [Percent; N],
}

#[derive(Debug, Clone)]
struct State<const N: usize> {
    last: [EncoderCount; N],
    counts: [i32; N],
    rate: [Rate; N],
    integrator: [Percent; N],
    duty: [Percent; N],
}

/// The coefficients of one product, digit by digit.
#[derive(Debug, Clone)]
struct Factors<const N: usize>([[i32; N]; 3]);

impl<const N: usize> Factors<N> {
    fn new(coefficient: impl Fn(usize) -> Coefficient) -> Self {
        Self(from_fn(|digit| {
            from_fn(|lane| coefficient(lane).digits()[digit])
        }))
    }

    #[inline(always)]
    fn of<From: Quantity, To: Quantity, const VECTOR: bool>(
        &self,
        lane: usize,
    ) -> Gain<From, To, VECTOR> {
        let [whole, upper, lower] = &self.0;
        Gain::of(Coefficient::of_digits([
            whole[lane],
            upper[lane],
            lower[lane],
        ]))
    }
}

impl<const N: usize> Gains<N> {
    fn new(c: &[Coefficients; N]) -> Self {
        Self {
            reversed: from_fn(|lane| c[lane].mounting.reversed),
            filter: Factors::new(|lane| c[lane].filter.coefficient()),
            position: Factors::new(|lane| c[lane].position.gain.coefficient()),
            min: from_fn(|lane| c[lane].position.min),
            max: from_fn(|lane| c[lane].position.max),
            rate_down: from_fn(|lane| c[lane].position.rate_down),
            rate_up: from_fn(|lane| c[lane].position.rate_up),
            proportional: Factors::new(|lane| c[lane].rate.proportional.coefficient()),
            integral: Factors::new(|lane| c[lane].rate.integral.coefficient()),
            anti_windup: Factors::new(|lane| c[lane].rate.anti_windup.coefficient()),
            feed_forward: Factors::new(|lane| c[lane].rate.feed_forward.coefficient()),
            feeds_forward: c.iter().any(|c| c.rate.feed_forward != Gain::default()),
            duty_limit: from_fn(|lane| c[lane].rate.duty_limit),
            duty_step: from_fn(|lane| c[lane].rate.duty_step),
        }
    }

    #[inline(always)]
    fn mounting(&self, lane: usize) -> Mounting {
        Mounting {
            // Matters at the first count alone.
            zero: EncoderCount::new(0),
            reversed: self.reversed[lane],
        }
    }

    #[inline(always)]
    fn position_loop<const VECTOR: bool>(&self, lane: usize) -> PositionLoop<VECTOR> {
        PositionLoop {
            gain: self.position.of(lane),
            min: self.min[lane],
            max: self.max[lane],
            rate_up: self.rate_up[lane],
            rate_down: self.rate_down[lane],
        }
    }

    #[inline(always)]
    fn rate_loop<const VECTOR: bool, const FORWARD: bool>(&self, lane: usize) -> RateLoop<VECTOR> {
        RateLoop {
            proportional: self.proportional.of(lane),
            integral: self.integral.of(lane),
            anti_windup: self.anti_windup.of(lane),
            feed_forward: if FORWARD {
                self.feed_forward.of(lane)
            } else {
                Gain::default()
            },
            duty_limit: self.duty_limit[lane],
            duty_step: self.duty_step[lane],
        }
    }
}

impl<const N: usize> CascadeLanes<N> {
    /// Actuators at rest whose encoders stand at count 0.
    pub fn new(coefficients: &[Coefficients; N]) -> Self {
        let first = EncoderCount::new(0);
        let mut state = State {
            last: [first; N],
            counts: [0; N],
            rate: [Rate::ZERO; N],
            integrator: [Percent::ZERO; N],
            duty: [Percent::ZERO; N],
        };
        for (lane, coefficients) in coefficients.iter().enumerate() {
            let mut shaft = ShaftTracker::default();
            shaft.update(coefficients.mounting, first);
            state.counts[lane] = shaft.counts;
        }
        let gains = Gains::new(coefficients);
        Self { gains, state }
    }

    /// The measured angle of an actuator, deg, and its estimated rate, deg/s.
    pub fn measured(&self, lane: usize) -> (Angle, Rate) {
        (self.state.shaft(lane).angle(), self.state.rate[lane])
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
    pub fn control_period(&mut self, counts: &[i64; N], commands: &[Angle; N]) -> [i64; N] {
        match (N > 1, self.gains.feeds_forward) {
            (false, false) => self.control_period_by::<false, false>(counts, commands),
            (false, true) => self.control_period_by::<false, true>(counts, commands),
            (true, false) => self.control_period_by::<true, false>(counts, commands),
            (true, true) => self.control_period_by::<true, true>(counts, commands),
        }
    }

    /// The parts of the control step are loops of their own: in one loop the next actuators would
    /// wait for the products of the ones before.
    #[inline(always)]
    fn control_period_by<const VECTOR: bool, const FORWARD: bool>(
        &mut self,
        counts: &[i64; N],
        commands: &[Angle; N],
    ) -> [i64; N] {
        let (gains, states) = (&self.gains, &mut self.state);
        let mut rate_commands = [Rate::ZERO; N];
        let mut duty = [0; N];
        for (lane, count) in counts.iter().enumerate() {
            let count = EncoderCount::new(*count as u16);
            let (mut shaft, mut rate) = (states.shaft(lane), RateEstimate(states.rate[lane]));
            let motion = shaft.update(gains.mounting(lane), count);
            rate.update(gains.filter.of::<_, _, VECTOR>(lane), motion);
            states.last[lane] = count;
            states.counts[lane] = shaft.counts;
            states.rate[lane] = rate.rate();
        }
        for (lane, command) in commands.iter().enumerate() {
            let position_loop = gains.position_loop::<VECTOR>(lane);
            let command = position_loop.follow_angle(*command, states.shaft(lane).angle());
            rate_commands[lane] = command.rate;
        }
        for (lane, duty) in duty.iter_mut().enumerate() {
            let rate_loop = gains.rate_loop::<VECTOR, FORWARD>(lane);
            let mut state = RateLoopState::of(states.integrator[lane], states.duty[lane]);
            let limited = state.regulate(&rate_loop, rate_commands[lane], states.rate[lane]);
            *duty = limited.duty.to_bits();
            states.integrator[lane] = state.integrator;
            states.duty[lane] = limited.duty;
        }
        duty
    }
}

impl<const N: usize> State<N> {
    /// Without a correction of the encoder, which lanes do not have.
    #[inline(always)]
    fn shaft(&self, lane: usize) -> ShaftTracker {
        ShaftTracker::at(self.counts[lane], self.last[lane])
    }
}
