//! The modes of the grey box: the range of the duty, times the active limit of the rate.
//!
//! The states are angle, rate of the motor and integrator. Every signal that is affine in state and
//! command is a row of coefficients: of angle, rate, integrator, command and one.

use super::GreyBoxValues;
use crate::hybrid::{Guard, HybridModel, LinearSystem};
use crate::model::ActiveLimit;
use crate::scalar::Scalar;

/// The closed loop with these parameters.
pub struct Servo<S>(pub GreyBoxValues<S>);

/// Ranges of the duty.
const POSITIVE: usize = 0;
const NEGATIVE: usize = 1;
const FULL: usize = 2;
const REVERSE: usize = 3;
const DUTIES: usize = 4;

/// Active limits of the rate.
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

    fn guard(self, next: usize) -> Guard<S, 3> {
        let [angle, rate, integral, command, constant] = self.0;
        Guard {
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
            RATE_UP => Row::constant(self.0.rate_limit_up_deg_s),
            RATE_DOWN => Row::constant(-self.0.rate_limit_down_deg_s),
            _ => Row::unit(1),
        };
        let error = Row::unit(3)
            .plus(minus, Row::unit(0))
            .times(self.0.position_gain)
            .plus(minus, limited_rate);
        let demand = Row::unit(2).plus(self.0.proportional_gain, error);
        let duty = match duty {
            FULL => Row::constant(self.0.duty_limit_pct),
            REVERSE => Row::constant(-self.0.duty_limit_pct),
            _ => demand,
        };
        Signals {
            limited_rate,
            error,
            demand,
            duty,
        }
    }

    fn duty_guards(&self, hold: usize, duty: usize, guards: &mut Vec<Guard<S, 3>>) {
        let demand = self.signals(hold, duty).demand;
        let (minus, limit) = (S::constant(-1.0), Row::constant(self.0.duty_limit_pct));
        let one = S::constant(1.0);
        // The motor remains at a stop only while its duty points outward.
        let across = |other: usize| match hold {
            STOP_HIGH | STOP_LOW => mode(FREE, other),
            _ => mode(hold, other),
        };
        match duty {
            POSITIVE => {
                guards.push(demand.guard(across(NEGATIVE)));
                guards.push(limit.plus(minus, demand).guard(mode(hold, FULL)));
            }
            NEGATIVE => {
                guards.push(demand.times(minus).guard(across(POSITIVE)));
                guards.push(limit.plus(one, demand).guard(mode(hold, REVERSE)));
            }
            FULL => guards.push(demand.plus(minus, limit).guard(mode(hold, POSITIVE))),
            _ => guards.push(
                demand
                    .times(minus)
                    .plus(minus, limit)
                    .guard(mode(hold, NEGATIVE)),
            ),
        }
    }

    fn hold_guards(&self, hold: usize, duty: usize, guards: &mut Vec<Guard<S, 3>>) {
        let (one, minus) = (S::constant(1.0), S::constant(-1.0));
        let (angle, rate) = (Row::unit(0), Row::unit(1));
        let mut limit = |sign: S, row: Row<S>, level: S, next: usize| {
            if level.value().is_finite() {
                let guard = Row::constant(level).plus(sign, row);
                guards.push(guard.guard(mode(next, duty)));
            }
        };
        match hold {
            FREE => {
                limit(minus, rate, self.0.rate_limit_up_deg_s, RATE_UP);
                limit(one, rate, self.0.rate_limit_down_deg_s, RATE_DOWN);
            }
            RATE_UP => limit(one, rate, -self.0.rate_limit_up_deg_s, FREE),
            RATE_DOWN => limit(minus, rate, -self.0.rate_limit_down_deg_s, FREE),
            _ => return,
        }
        limit(minus, angle, self.0.position_limit_deg, STOP_HIGH);
        limit(one, angle, self.0.position_limit_deg, STOP_LOW);
    }
}

impl<S: Scalar> HybridModel<S, 3> for Servo<S> {
    const MODES: usize = HOLDS * DUTIES;

    fn system(&self, mode: usize) -> LinearSystem<S, 3> {
        let (hold, duty) = (mode / DUTIES, mode % DUTIES);
        let signals = self.signals(hold, duty);
        let minus = S::constant(-1.0);
        let gain = if matches!(duty, POSITIVE | FULL) {
            self.0.motor_gain_up
        } else {
            self.0.motor_gain_down
        };
        let excess = signals.duty.plus(minus, signals.demand);
        let over = signals.limited_rate.plus(minus, Row::unit(1));
        let integral = signals
            .error
            .times(self.0.integral_gain)
            .plus(self.0.anti_windup_gain, excess)
            .plus(self.0.rate_anti_windup_gain, over);
        let is_stopped = hold >= STOP_HIGH;
        let rows = if is_stopped {
            let still = Row::constant(S::constant(0.0));
            [still, still, integral]
        } else {
            let per_time = S::constant(1.0) / self.0.motor_time_constant_s;
            let acceleration = signals.duty.times(gain).plus(minus, Row::unit(1));
            [signals.limited_rate, acceleration.times(per_time), integral]
        };
        LinearSystem {
            a: rows.map(|row| [row.0[0], row.0[1], row.0[2]]),
            b: rows.map(|row| row.0[3]),
            d: rows.map(|row| row.0[4]),
        }
    }

    fn guards(&self, mode: usize) -> Vec<Guard<S, 3>> {
        let (hold, duty) = (mode / DUTIES, mode % DUTIES);
        // At a stop the rate is zero; an inward duty leaves it at once.
        let is_inward = match hold {
            STOP_HIGH => matches!(duty, NEGATIVE | REVERSE),
            STOP_LOW => matches!(duty, POSITIVE | FULL),
            _ => false,
        };
        if is_inward {
            let never = Row::constant(S::constant(-1.0));
            return vec![never.guard(self::mode(FREE, duty))];
        }
        let mut guards = Vec::with_capacity(6);
        self.duty_guards(hold, duty, &mut guards);
        self.hold_guards(hold, duty, &mut guards);
        guards
    }

    fn mode_at(&self, x: &[f64; 3], command: f64) -> usize {
        let [angle, rate, _] = *x;
        let hold = if rate > self.0.rate_limit_up_deg_s.value() {
            RATE_UP
        } else if rate < -self.0.rate_limit_down_deg_s.value() {
            RATE_DOWN
        } else {
            FREE
        };
        let demand = self.signals(hold, POSITIVE).demand.at(x, command);
        let duty = if demand > self.0.duty_limit_pct.value() {
            FULL
        } else if demand < -self.0.duty_limit_pct.value() {
            REVERSE
        } else if demand > 0.0 {
            POSITIVE
        } else {
            NEGATIVE
        };
        let stop = self.0.position_limit_deg.value();
        if angle >= stop && rate >= 0.0 && demand > 0.0 {
            mode(STOP_HIGH, duty)
        } else if angle <= -stop && rate <= 0.0 && demand < 0.0 {
            mode(STOP_LOW, duty)
        } else {
            mode(hold, duty)
        }
    }

    fn reset(&self, mode: usize, x: &mut [S; 3]) {
        let stop = match mode / DUTIES {
            STOP_HIGH => self.0.position_limit_deg,
            STOP_LOW => -self.0.position_limit_deg,
            _ => return,
        };
        (x[0], x[1]) = (stop, S::constant(0.0));
    }

    fn output(&self, mode: usize, x: &[S; 3], _command: f64) -> (S, f64, ActiveLimit) {
        let (hold, duty) = (mode / DUTIES, mode % DUTIES);
        let (up, down) = (
            self.0.rate_limit_up_deg_s.value(),
            self.0.rate_limit_down_deg_s.value(),
        );
        let rate = x[1].value().clamp(-down.abs(), up.abs());
        let state = match hold {
            RATE_UP => ActiveLimit::RateUp,
            RATE_DOWN => ActiveLimit::RateDown,
            STOP_HIGH | STOP_LOW => ActiveLimit::Stop,
            _ if duty >= FULL => ActiveLimit::Duty,
            _ => ActiveLimit::Free,
        };
        (x[0], rate, state)
    }
}
