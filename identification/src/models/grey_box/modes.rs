//! The modes of the grey box: what the duty does, and what holds the rate.
//!
//! Its states are angle, rate of the motor and integrator. Of everything that is affine in state
//! and command a row of coefficients is kept: angle, rate, integrator, command, one.

use crate::flow::{Face, Flow, System};
use crate::model::State;
use crate::scalar::Scalar;

/// The parameters of the grey box.
pub struct Servo<S> {
    pub gain_up: S,
    pub gain_down: S,
    pub time_constant: S,
    pub proportional: S,
    pub integral: S,
    pub position: S,
    pub anti_windup: S,
    pub rate_anti_windup: S,
    pub duty_limit: S,
    pub up: S,
    pub down: S,
    pub stop: S,
}

/// What the duty does.
const POSITIVE: usize = 0;
const NEGATIVE: usize = 1;
const FULL: usize = 2;
const REVERSE: usize = 3;
const DUTIES: usize = 4;

/// What holds the rate.
const FREE: usize = 0;
const RATE_UP: usize = 1;
const RATE_DOWN: usize = 2;
const STOP_HIGH: usize = 3;
const STOP_LOW: usize = 4;
const HOLDS: usize = 5;

const fn mode(hold: usize, duty: usize) -> usize {
    hold * DUTIES + duty
}

/// Coefficients of angle, rate, integrator, command and one.
#[derive(Clone, Copy)]
struct Row<S>([S; 5]);

impl<S: Scalar> Row<S> {
    fn constant(value: S) -> Self {
        let zero = S::constant(0.0);
        Self([zero, zero, zero, zero, value])
    }

    fn unit(index: usize) -> Self {
        let value = |i| S::constant(if i == index { 1.0 } else { 0.0 });
        Self(std::array::from_fn(value))
    }

    fn plus(self, factor: S, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + factor * other.0[i]))
    }

    fn times(self, factor: S) -> Self {
        Self(self.0.map(|c| c * factor))
    }

    fn face(self, next: usize) -> Face<S, 3> {
        let [angle, rate, integral, command, constant] = self.0;
        Face {
            row: [angle, rate, integral],
            command,
            constant,
            next,
        }
    }

    fn at(&self, x: &[f64; 3], command: f64) -> f64 {
        let [angle, rate, integral, by_command, constant] = self.0.map(S::value);
        angle * x[0] + rate * x[1] + integral * x[2] + by_command * command + constant
    }
}

/// Signals of the controller in a mode.
struct Signals<S> {
    limited_rate: Row<S>,
    error: Row<S>,
    demand: Row<S>,
    duty: Row<S>,
}

impl<S: Scalar> Servo<S> {
    fn signals(&self, hold: usize, duty: usize) -> Signals<S> {
        let minus = S::constant(-1.0);
        let limited_rate = match hold {
            RATE_UP => Row::constant(self.up),
            RATE_DOWN => Row::constant(-self.down),
            _ => Row::unit(1),
        };
        let error = Row::unit(3)
            .plus(minus, Row::unit(0))
            .times(self.position)
            .plus(minus, limited_rate);
        let demand = Row::unit(2).plus(self.proportional, error);
        let duty = match duty {
            FULL => Row::constant(self.duty_limit),
            REVERSE => Row::constant(-self.duty_limit),
            _ => demand,
        };
        Signals {
            limited_rate,
            error,
            demand,
            duty,
        }
    }

    fn duty_faces(&self, hold: usize, duty: usize, faces: &mut Vec<Face<S, 3>>) {
        let demand = self.signals(hold, duty).demand;
        let (minus, limit) = (S::constant(-1.0), Row::constant(self.duty_limit));
        let one = S::constant(1.0);
        // At a stop the motor stays only while it pushes outward.
        let across = |other: usize| match hold {
            STOP_HIGH | STOP_LOW => mode(FREE, other),
            _ => mode(hold, other),
        };
        match duty {
            POSITIVE => {
                faces.push(demand.face(across(NEGATIVE)));
                faces.push(limit.plus(minus, demand).face(mode(hold, FULL)));
            }
            NEGATIVE => {
                faces.push(demand.times(minus).face(across(POSITIVE)));
                faces.push(limit.plus(one, demand).face(mode(hold, REVERSE)));
            }
            FULL => faces.push(demand.plus(minus, limit).face(mode(hold, POSITIVE))),
            _ => faces.push(
                demand
                    .times(minus)
                    .plus(minus, limit)
                    .face(mode(hold, NEGATIVE)),
            ),
        }
    }

    fn hold_faces(&self, hold: usize, duty: usize, faces: &mut Vec<Face<S, 3>>) {
        let (one, minus) = (S::constant(1.0), S::constant(-1.0));
        let (angle, rate) = (Row::unit(0), Row::unit(1));
        let mut limit = |sign: S, row: Row<S>, level: S, next: usize| {
            if level.value().is_finite() {
                let face = Row::constant(level).plus(sign, row);
                faces.push(face.face(mode(next, duty)));
            }
        };
        match hold {
            FREE => {
                limit(minus, rate, self.up, RATE_UP);
                limit(one, rate, self.down, RATE_DOWN);
            }
            RATE_UP => limit(one, rate, -self.up, FREE),
            RATE_DOWN => limit(minus, rate, -self.down, FREE),
            _ => return,
        }
        limit(minus, angle, self.stop, STOP_HIGH);
        limit(one, angle, self.stop, STOP_LOW);
    }
}

impl<S: Scalar> Flow<S, 3> for Servo<S> {
    const MODES: usize = HOLDS * DUTIES;

    fn system(&self, mode: usize) -> System<S, 3> {
        let (hold, duty) = (mode / DUTIES, mode % DUTIES);
        let signals = self.signals(hold, duty);
        let minus = S::constant(-1.0);
        let gain = if matches!(duty, POSITIVE | FULL) {
            self.gain_up
        } else {
            self.gain_down
        };
        let excess = signals.duty.plus(minus, signals.demand);
        let over = signals.limited_rate.plus(minus, Row::unit(1));
        let integral = signals
            .error
            .times(self.integral)
            .plus(self.anti_windup, excess)
            .plus(self.rate_anti_windup, over);
        let is_stopped = hold >= STOP_HIGH;
        let rows = if is_stopped {
            let still = Row::constant(S::constant(0.0));
            [still, still, integral]
        } else {
            let per_time = S::constant(1.0) / self.time_constant;
            let acceleration = signals.duty.times(gain).plus(minus, Row::unit(1));
            [signals.limited_rate, acceleration.times(per_time), integral]
        };
        System {
            a: rows.map(|row| [row.0[0], row.0[1], row.0[2]]),
            b: rows.map(|row| row.0[3]),
            d: rows.map(|row| row.0[4]),
        }
    }

    fn faces(&self, mode: usize) -> Vec<Face<S, 3>> {
        let (hold, duty) = (mode / DUTIES, mode % DUTIES);
        // A stop takes the rate; a motor that pushes away from it leaves at once.
        let is_inward = match hold {
            STOP_HIGH => matches!(duty, NEGATIVE | REVERSE),
            STOP_LOW => matches!(duty, POSITIVE | FULL),
            _ => false,
        };
        if is_inward {
            let never = Row::constant(S::constant(-1.0));
            return vec![never.face(self::mode(FREE, duty))];
        }
        let mut faces = Vec::with_capacity(6);
        self.duty_faces(hold, duty, &mut faces);
        self.hold_faces(hold, duty, &mut faces);
        faces
    }

    fn mode_at(&self, x: &[f64; 3], command: f64) -> usize {
        let [angle, rate, _] = *x;
        let hold = if rate > self.up.value() {
            RATE_UP
        } else if rate < -self.down.value() {
            RATE_DOWN
        } else {
            FREE
        };
        let demand = self.signals(hold, POSITIVE).demand.at(x, command);
        let duty = if demand > self.duty_limit.value() {
            FULL
        } else if demand < -self.duty_limit.value() {
            REVERSE
        } else if demand > 0.0 {
            POSITIVE
        } else {
            NEGATIVE
        };
        let stop = self.stop.value();
        if angle >= stop && rate >= 0.0 && demand > 0.0 {
            mode(STOP_HIGH, duty)
        } else if angle <= -stop && rate <= 0.0 && demand < 0.0 {
            mode(STOP_LOW, duty)
        } else {
            mode(hold, duty)
        }
    }

    fn enter(&self, mode: usize, x: &mut [S; 3]) {
        let stop = match mode / DUTIES {
            STOP_HIGH => self.stop,
            STOP_LOW => -self.stop,
            _ => return,
        };
        (x[0], x[1]) = (stop, S::constant(0.0));
    }

    fn seen(&self, mode: usize, x: &[S; 3], _command: f64) -> (S, f64, State) {
        let (hold, duty) = (mode / DUTIES, mode % DUTIES);
        let (up, down) = (self.up.value(), self.down.value());
        let rate = x[1].value().clamp(-down.abs(), up.abs());
        let state = match hold {
            RATE_UP => State::RateUp,
            RATE_DOWN => State::RateDown,
            STOP_HIGH | STOP_LOW => State::Stop,
            _ if duty >= FULL => State::Duty,
            _ => State::Free,
        };
        (x[0], rate, state)
    }
}
