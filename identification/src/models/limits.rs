//! The limits of rate and position, gain and offset of both black boxes.

use crate::hybrid::Guard;
use crate::model::ActiveLimit;
use crate::scalar::Scalar;

/// The modes of both: free, or one of the limits is active.
pub const FREE: usize = 0;
pub const RATE_UP: usize = 1;
pub const RATE_DOWN: usize = 2;
pub const STOP_HIGH: usize = 3;
pub const STOP_LOW: usize = 4;
pub const MODES: usize = 5;

/// The limits, and the steady angle of a command.
pub struct Limits<S> {
    pub up: S,
    pub down: S,
    pub gain: S,
    pub offset: S,
    pub stop: S,
}

impl<S: Scalar> Limits<S> {
    /// The steady angle of a command, deg.
    #[inline]
    pub fn target(&self, command: f64) -> f64 {
        self.gain.value() * command + self.offset.value()
    }

    /// `sign x[state] + limit`.
    pub fn guard<const N: usize>(state: usize, sign: f64, limit: S, next: usize) -> Guard<S, N> {
        let mut row = [S::constant(0.0); N];
        row[state] = S::constant(sign);
        Guard {
            row,
            command: S::constant(0.0),
            constant: limit,
            next,
        }
    }

    /// Adds the guards of the stops, if there are any, the angle being the first state.
    pub fn stops<const N: usize>(&self, guards: &mut Vec<Guard<S, N>>) {
        if self.stop.value().is_finite() {
            guards.push(Self::guard(0, -1.0, self.stop, STOP_HIGH));
            guards.push(Self::guard(0, 1.0, self.stop, STOP_LOW));
        }
    }
}

/// The active limit of a mode.
#[inline]
pub fn state(mode: usize) -> ActiveLimit {
    match mode {
        FREE => ActiveLimit::Free,
        RATE_UP => ActiveLimit::RateUp,
        RATE_DOWN => ActiveLimit::RateDown,
        _ => ActiveLimit::Stop,
    }
}
