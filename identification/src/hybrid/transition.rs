//! The transition of a linear system over one step length, as matrices.
//!
//! All of it follows from `P = integral of exp(A t)`: `exp(A h) = 1 + A P`, and a constant command
//! adds `P (b c + d)`. The terms of a changing command are computed on first use.

use super::Command;
use super::linear::LinearSystem;
use crate::scalar::Scalar;

/// The solution over one step length: linear in state and coefficients of the command.
#[derive(Clone)]
pub struct Transition<S, const N: usize> {
    step: S,
    terms: usize,
    state: [[S; N]; N],
    command: [S; N],
    constant: [S; N],
    /// The last constant command, by its bits, and the term that it adds.
    held_input: (u64, [S; N]),
    /// The terms that the powers 1 to 3 of the time add.
    moments: Option<Box<[[S; N]; 3]>>,
}

impl<S: Scalar, const N: usize> Transition<S, N> {
    /// Over `step`, with this number of terms of the series.
    pub fn new(system: &LinearSystem<S, N>, step: S, terms: usize) -> Self {
        let zero = [S::constant(0.0); N];
        let mut columns = [zero; N];
        for (j, column) in columns.iter_mut().enumerate() {
            *column = system.series(&zero, step, terms, |k, next| {
                if k == 0 {
                    next[j] = next[j] + 1.0;
                }
            });
        }
        let mut state = [zero; N];
        let (mut command, mut constant) = (zero, zero);
        for (j, column) in columns.iter().enumerate() {
            let transform = system.apply(column);
            for i in 0..N {
                state[i][j] = if i == j {
                    transform[i] + 1.0
                } else {
                    transform[i]
                };
                command[i] = command[i] + column[i] * system.b[j];
                constant[i] = constant[i] + column[i] * system.d[j];
            }
        }
        Self {
            step,
            terms,
            state,
            command,
            constant,
            held_input: (0.0_f64.to_bits(), constant),
            moments: None,
        }
    }

    /// Over twice the step.
    pub fn doubled(&self) -> Self {
        let zero = [S::constant(0.0); N];
        let column = |j: usize| self.transform(&std::array::from_fn(|i| self.state[i][j]), &zero);
        let columns: [[S; N]; N] = std::array::from_fn(column);
        let state = std::array::from_fn(|i| std::array::from_fn(|j| columns[j][i]));
        let constant = self.transform(&self.constant, &self.constant);
        Self {
            step: self.step * 2.0,
            terms: self.terms,
            state,
            command: self.transform(&self.command, &self.command),
            constant,
            held_input: (0.0_f64.to_bits(), constant),
            moments: self
                .moments
                .as_ref()
                .map(|m| Box::new(self.doubled_moments(m))),
        }
    }

    /// The terms of the powers of the time over twice the step: `u^k` is `(u + h)^k` in its second
    /// half.
    fn doubled_moments(&self, moments: &[[S; N]; 3]) -> [[S; N]; 3] {
        let h = self.step;
        let powers = [h, h * h, h * h * h];
        // The contribution of the lower powers in the second half.
        let more = |k: usize, i: usize| match k {
            0 => self.command[i] * powers[0],
            1 => self.command[i] * powers[1] + moments[0][i] * powers[0] * 2.0,
            _ => {
                let of_both = moments[0][i] * powers[1] + moments[1][i] * powers[0];
                self.command[i] * powers[2] + of_both * 3.0
            }
        };
        std::array::from_fn(|k| {
            let second = std::array::from_fn(|i| moments[k][i] + more(k, i));
            self.transform(&moments[k], &second)
        })
    }

    /// Whether the terms of a changing command have been computed.
    pub fn has_moments(&self) -> bool {
        self.moments.is_some()
    }

    /// Computes the terms of a changing command from the series over a short step, `system` being
    /// that of this transition.
    pub fn make_moments(&mut self, system: &LinearSystem<S, N>) -> &[[S; N]; 3] {
        let Self { step, terms, .. } = *self;
        let make = || Box::new(moments(system, step, terms));
        self.moments.get_or_insert_with(make)
    }

    /// `exp(A h) x + more`.
    #[inline(always)]
    fn transform(&self, x: &[S; N], more: &[S; N]) -> [S; N] {
        let mut sums = *more;
        for (sum, row) in sums.iter_mut().zip(&self.state) {
            for j in 0..N {
                *sum = *sum + row[j] * x[j];
            }
        }
        sums
    }

    /// The state after the step under a constant command.
    #[inline(always)]
    pub fn under_held_command(&mut self, x: &[S; N], command: f64) -> [S; N] {
        if self.held_input.0 != command.to_bits() {
            self.held_input.0 = command.to_bits();
            for i in 0..N {
                self.held_input.1[i] = self.constant[i] + self.command[i] * command;
            }
        }
        self.transform(x, &self.held_input.1)
    }

    /// The state after the step, `system` being that of this transition.
    pub fn apply(
        &mut self,
        x: &[S; N],
        command: &Command<S>,
        system: &LinearSystem<S, N>,
    ) -> [S; N] {
        let q = match command {
            Command::Constant(value) => return self.under_held_command(x, *value),
            Command::Cubic(q) => q,
        };
        let mut more = self.constant;
        let command = self.command;
        let moments = self.make_moments(system);
        for i in 0..N {
            more[i] = more[i] + command[i] * q[0];
            for (moment, q) in moments.iter().zip(&q[1..]) {
                more[i] = more[i] + moment[i] * *q;
            }
        }
        self.transform(x, &more)
    }
}

/// The terms that the powers 1 to 3 of the time add over a step.
fn moments<S: Scalar, const N: usize>(
    system: &LinearSystem<S, N>,
    step: S,
    terms: usize,
) -> [[S; N]; 3] {
    let zero = [S::constant(0.0); N];
    let held_input = LinearSystem { d: zero, ..*system };
    let mut moments = [zero; 3];
    for (k, moment) in moments.iter_mut().enumerate() {
        let mut unit = [S::constant(0.0); 4];
        unit[k + 1] = S::constant(1.0);
        *moment = held_input.solve(&zero, &Command::Cubic(unit), step, terms);
    }
    moments
}

#[cfg(test)]
mod tests {
    use super::*;

    const SYSTEM: LinearSystem<f64, 2> = LinearSystem {
        a: [[0.0, 1.0], [-90.0, -7.0]],
        b: [0.0, 90.0],
        d: [0.3, -2.0],
    };
    const COMMANDS: [Command<f64>; 3] = [
        Command::Constant(0.0),
        Command::Constant(3.0),
        Command::Cubic([3.0, -4.0, 50.0, 700.0]),
    ];

    fn assert_same(a: [f64; 2], b: [f64; 2]) {
        for i in 0..2 {
            // Rounding of values around 20.
            assert!((a[i] - b[i]).abs() < 1e-13, "{a:?} {b:?}");
        }
    }

    #[test]
    fn the_matrices_agree_with_their_series() {
        let mut transition = Transition::new(&SYSTEM, 0.02, 24);
        let x = [1.5, -20.0];
        for command in COMMANDS {
            let expected = SYSTEM.solve(&x, &command, 0.02, 24);
            assert_same(transition.apply(&x, &command, &SYSTEM), expected);
        }
    }

    #[test]
    fn two_steps_are_one_of_twice_the_length() {
        let mut half = Transition::new(&SYSTEM, 0.01, 24);
        half.make_moments(&SYSTEM);
        let mut doubled = half.doubled();
        let x = [1.5, -20.0];
        for command in COMMANDS {
            let expected = SYSTEM.solve(&x, &command, 0.02, 24);
            assert_same(doubled.apply(&x, &command, &SYSTEM), expected);
        }
    }
}
