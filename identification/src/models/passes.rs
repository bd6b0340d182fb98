//! Runs of a model with derivatives: all in one pass, or eight a pass.

use super::Dynamics;
use crate::experiment::Experiment;
use crate::flow::Watch;
use crate::model::{State, Sums};
use crate::scalar::{Dual, Scalar};

/// The parameters, those of `free` as what derivatives are by.
fn duals<const N: usize>(values: &[f64], free: &[usize]) -> Vec<Dual<N>> {
    let mut duals: Vec<Dual<N>> = values.iter().map(|v| Dual::constant(*v)).collect();
    for (index, parameter) in free.iter().enumerate() {
        duals[*parameter] = Dual::parameter(values[*parameter], index);
    }
    duals
}

/// The sums with a width that the compiler knows: the inner loop of every search, in the widest
/// registers of this machine.
pub fn sums_with_duals<const N: usize, D: Dynamics>(
    model: &D,
    run: &Experiment,
    values: &[f64],
    free: &[usize],
    angles: &[f64],
) -> Sums {
    let (values, width) = (duals::<N>(values, free), free.len());
    let totals = pulp::Arch::new().dispatch(Summing {
        model,
        run,
        values: &values,
        angles,
    });
    Sums {
        squares: totals.squares,
        samples: totals.samples,
        products: totals.products[..width].to_vec(),
        information: totals.information[..width]
            .iter()
            .flat_map(|row| &row[..width])
            .copied()
            .collect(),
    }
}

/// [`Sums`] of known width.
struct Totals<const N: usize> {
    squares: f64,
    samples: usize,
    products: [f64; N],
    information: [[f64; N]; N],
}

struct Summing<'a, D, const N: usize> {
    model: &'a D,
    run: &'a Experiment,
    values: &'a [Dual<N>],
    angles: &'a [f64],
}

impl<D: Dynamics, const N: usize> pulp::NullaryFnOnce for Summing<'_, D, N> {
    type Output = Totals<N>;

    #[inline(always)]
    fn call(self) -> Totals<N> {
        let mut totals = Totals {
            squares: 0.0,
            samples: 0,
            products: [0.0; N],
            information: [[0.0; N]; N],
        };
        let seen = &mut Comparing {
            angles: self.angles,
            totals: &mut totals,
        };
        self.model.run(self.run, self.values, seen);
        totals
    }
}

/// Compares what is seen with what was measured.
struct Comparing<'a, const N: usize> {
    angles: &'a [f64],
    totals: &'a mut Totals<N>,
}

impl<const N: usize> Watch<Dual<N>> for Comparing<'_, N> {
    #[inline(always)]
    fn see(&mut self, i: usize, angle: Dual<N>, _rate_deg_s: f64, state: State) {
        let residual = self.angles[i] - angle.value;
        // Another answer that is none spoils the sums.
        if self.angles[i].is_nan() || state == State::Off {
            return;
        }
        let totals = &mut *self.totals;
        totals.squares += residual * residual;
        totals.samples += 1;
        for row in 0..N {
            totals.products[row] += angle.slope[row] * residual;
            for column in 0..N {
                totals.information[row][column] += angle.slope[row] * angle.slope[column];
            }
        }
    }
}

/// The sums of more than eight parameters.
pub fn sums_in_passes<D: Dynamics>(
    model: &D,
    run: &Experiment,
    values: &[f64],
    free: &[usize],
    angles: &[f64],
) -> Sums {
    let mut sums = Sums::new(free.len());
    // Where the motor is off, no answer is no failure.
    let is_switched = run.recording.motor_on.is_some();
    in_passes(model, run, values, free, &mut |i, angle, slope| {
        if !angles[i].is_nan() && !(is_switched && angle.is_nan()) {
            sums.add(angles[i] - angle, slope);
        }
    });
    sums
}

/// One pass with all the derivatives.
pub fn with_duals<const N: usize, D: Dynamics>(
    model: &D,
    run: &Experiment,
    values: &[f64],
    free: &[usize],
    seen: &mut dyn FnMut(usize, f64, &[f64]),
) {
    model.run(run, &duals(values, free), &mut |i, angle: Dual<N>, _, _| {
        seen(i, angle.value, &angle.slope[..free.len()]);
    });
}

/// Eight derivatives a pass, for more than eight.
pub fn in_passes<D: Dynamics>(
    model: &D,
    run: &Experiment,
    values: &[f64],
    free: &[usize],
    seen: &mut dyn FnMut(usize, f64, &[f64]),
) {
    let width = free.len();
    let mut angles = vec![f64::NAN; run.len()];
    let mut slopes = vec![f64::NAN; run.len() * width];
    for (pass, some) in free.chunks(8).enumerate() {
        with_duals::<8, D>(model, run, values, some, &mut |i, angle, slope| {
            angles[i] = angle;
            let start = i * width + pass * 8;
            slopes[start..start + some.len()].copy_from_slice(slope);
        });
    }
    for (i, angle) in angles.iter().enumerate() {
        seen(i, *angle, &slopes[i * width..(i + 1) * width]);
    }
}
