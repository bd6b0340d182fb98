//! What both black boxes have around their lag: limits of rate and position, gain and offset.

use crate::flow::Face;
use crate::model::State;
use crate::scalar::Scalar;

/// Modes of both: nothing limits them, or one of the limits does.
pub const FREE: usize = 0;
pub const RATE_UP: usize = 1;
pub const RATE_DOWN: usize = 2;
pub const STOP_HIGH: usize = 3;
pub const STOP_LOW: usize = 4;
pub const MODES: usize = 5;

/// The limits, and where a command leads to.
pub struct Limits<S> {
    pub up: S,
    pub down: S,
    pub gain: S,
    pub offset: S,
    pub stop: S,
}

impl<S: Scalar> Limits<S> {
    /// From the parameters of a model, in whose table they follow each other.
    pub fn new(values: &[S]) -> Self {
        let [up, down, gain, offset, stop] = std::array::from_fn(|i| values[i]);
        Self {
            up,
            down,
            gain,
            offset,
            stop,
        }
    }

    /// The angle at which a command comes to rest, deg.
    #[inline]
    pub fn target(&self, command: f64) -> f64 {
        self.gain.value() * command + self.offset.value()
    }

    /// `sign x[state] + limit`.
    pub fn face<const N: usize>(state: usize, sign: f64, limit: S, next: usize) -> Face<S, N> {
        let mut row = [S::constant(0.0); N];
        row[state] = S::constant(sign);
        Face {
            row,
            command: S::constant(0.0),
            constant: limit,
            next,
        }
    }

    /// Adds the stops where there are any, the angle being the first state.
    pub fn stops<const N: usize>(&self, faces: &mut Vec<Face<S, N>>) {
        if self.stop.value().is_finite() {
            faces.push(Self::face(0, -1.0, self.stop, STOP_HIGH));
            faces.push(Self::face(0, 1.0, self.stop, STOP_LOW));
        }
    }
}

/// Which limit holds in a mode.
#[inline]
pub fn state(mode: usize) -> State {
    match mode {
        FREE => State::Free,
        RATE_UP => State::RateUp,
        RATE_DOWN => State::RateDown,
        _ => State::Stop,
    }
}
