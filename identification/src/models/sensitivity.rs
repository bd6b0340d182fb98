//! Runs of a model with its sensitivities: in the search as wide as it needs, elsewhere eight in
//! each pass.

use std::ops::Range;

use super::Dynamics;
use crate::experiment::Experiment;
use crate::hybrid::Output;
use crate::loss::weighed;
use crate::model::{ActiveLimit, COMMANDS_PER_PASS, ParameterValues, Sums};
use crate::scalar::{Dual, Scalar};

/// The parameters as dual numbers, with those of `free` as the independent variables.
fn duals<const N: usize, D: Dynamics>(values: &[f64], free: &[usize]) -> D::Parameters<Dual<N>> {
    let mut duals: Vec<Dual<N>> = values.iter().map(|v| Dual::constant(*v)).collect();
    for (index, parameter) in free.iter().enumerate() {
        duals[*parameter] = Dual::parameter(values[*parameter], index);
    }
    D::Parameters::from_slice(&duals)
}

/// The sums with a width that is known at compile time: the inner loop of every search, in the
/// vector registers of the processor.
pub fn sums_with_duals<const N: usize, D: Dynamics>(
    model: &D,
    run: &Experiment,
    values: &[f64],
    free: &[usize],
    angles: &[f64],
) -> Sums {
    let (p, width) = (duals::<N, D>(values, free), free.len());
    let totals = vectorised(Summing {
        model,
        run,
        p: &p,
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

/// Calls it with AVX2 where the processor has that. At most eight derivatives gain nothing from
/// wider registers, for which there would be another copy of each model in the program.
fn vectorised<F: pulp::NullaryFnOnce>(function: F) -> F::Output {
    #[cfg(target_arch = "x86_64")]
    if let Some(avx2) = pulp::x86::V3::try_new() {
        return avx2.vectorize(function);
    }
    function.call()
}

/// Samples that are added to the sums together, row by row of the matrix, whose row then stays in
/// registers.
const BATCH: usize = 32;

/// [`Sums`] of known width, and the samples that are not in them yet.
struct Totals<const N: usize> {
    squares: f64,
    samples: usize,
    products: [f64; N],
    information: [[f64; N]; N],
    waiting: usize,
    residuals: [f64; BATCH],
    weighted: [[f64; N]; BATCH],
    slopes: [[f64; N]; BATCH],
}

impl<const N: usize> Totals<N> {
    const fn new() -> Self {
        Self {
            squares: 0.0,
            samples: 0,
            products: [0.0; N],
            information: [[0.0; N]; N],
            waiting: 0,
            residuals: [0.0; BATCH],
            weighted: [[0.0; N]; BATCH],
            slopes: [[0.0; N]; BATCH],
        }
    }

    #[inline(always)]
    fn add(&mut self, square: f64, residual: f64, weighted: &[f64; N], slope: &[f64; N]) {
        self.squares += square;
        self.samples += 1;
        let place = self.waiting % BATCH;
        self.residuals[place] = residual;
        self.weighted[place] = *weighted;
        self.slopes[place] = *slope;
        self.waiting = place + 1;
        if self.waiting == BATCH {
            self.add_waiting();
        }
    }

    /// Adds the samples that wait to the sums, in their order.
    #[inline(always)]
    fn add_waiting(&mut self) {
        let waiting = self.waiting.min(BATCH);
        let (residuals, weighted) = (&self.residuals[..waiting], &self.weighted[..waiting]);
        let slopes = &self.slopes[..waiting];
        for (residual, weighted) in residuals.iter().zip(weighted) {
            for (product, weighted) in self.products.iter_mut().zip(weighted) {
                *product += weighted * residual;
            }
        }
        for (i, place) in self.information.iter_mut().enumerate() {
            let mut row = *place;
            for (weighted, slopes) in weighted.iter().zip(slopes) {
                let factor = weighted[i];
                for (sum, slope) in row.iter_mut().zip(slopes) {
                    *sum += factor * slope;
                }
            }
            *place = row;
        }
        self.waiting = 0;
    }
}

struct Summing<'a, D: Dynamics, const N: usize> {
    model: &'a D,
    run: &'a Experiment,
    p: &'a D::Parameters<Dual<N>>,
    angles: &'a [f64],
}

impl<D: Dynamics, const N: usize> pulp::NullaryFnOnce for Summing<'_, D, N> {
    type Output = Totals<N>;

    #[inline(always)]
    fn call(self) -> Totals<N> {
        let mut totals = Totals::new();
        let output = &mut Comparison {
            angles: self.angles,
            curvature: self.run.loss.curvature(),
            totals: &mut totals,
        };
        self.model.run(self.run, self.p, output);
        totals.add_waiting();
        totals
    }
}

/// Compares the output with the measured angles.
struct Comparison<'a, const N: usize> {
    angles: &'a [f64],
    curvature: f64,
    totals: &'a mut Totals<N>,
}

impl<const N: usize> Output<Dual<N>> for Comparison<'_, N> {
    #[inline(always)]
    fn sample(&mut self, i: usize, angle: Dual<N>, _rate_deg_s: f64, state: ActiveLimit) {
        let residual = self.angles[i] - angle.value;
        // Any other NaN makes the sums NaN.
        if self.angles[i].is_nan() || state == ActiveLimit::Off {
            return;
        }
        let totals = &mut *self.totals;
        if self.curvature == 0.0 {
            totals.add(residual * residual, residual, &angle.slope, &angle.slope);
        } else {
            let (square, weight) = weighed(self.curvature, residual);
            totals.add(
                square,
                residual,
                &angle.slope.map(|s| weight * s),
                &angle.slope,
            );
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
    let curvature = run.loss.curvature();
    // Where the motor is off, NaN is not a divergence.
    let is_switched = run.recording.motor_on.is_some();
    in_passes(model, run, values, free, &mut |i, angle, slope| {
        let is_left_out = angles[i].is_nan() || is_switched && angle.is_nan();
        if !is_left_out {
            sums.add(curvature, angles[i] - angle, slope);
        }
    });
    sums
}

/// Derivatives of a pass outside the search. A separate width for each number of parameters would
/// save little there, and each is another copy of every model in the program.
const PASS: usize = COMMANDS_PER_PASS;

/// Passes the angle and the first derivatives of each sample on: one type for all callers, so that
/// they share one copy of the model.
struct Passing<'a> {
    width: usize,
    output: &'a mut dyn FnMut(usize, f64, &[f64]),
}

impl Output<Dual<PASS>> for Passing<'_> {
    #[inline(always)]
    fn sample(&mut self, i: usize, angle: Dual<PASS>, _rate_deg_s: f64, _state: ActiveLimit) {
        (self.output)(i, angle.value, &angle.slope[..self.width]);
    }
}

/// One pass with the derivatives by up to eight parameters.
fn in_one_pass<D: Dynamics>(
    model: &D,
    run: &Experiment,
    values: &[f64],
    free: &[usize],
    output: &mut dyn FnMut(usize, f64, &[f64]),
) {
    let width = free.len();
    let p = duals::<PASS, D>(values, free);
    model.run(run, &p, &mut Passing { width, output });
}

/// One pass with the derivatives by the levels of some segments of the command, up to eight.
pub fn by_command<D: Dynamics>(
    model: &D,
    run: &Experiment,
    values: &[f64],
    segments: Range<usize>,
    output: &mut dyn FnMut(usize, f64, &[f64]),
) {
    let width = segments.len();
    let mut run = run.clone();
    for (index, segment) in run.command[segments].iter_mut().enumerate() {
        segment.variable = Some(index);
    }
    let p = duals::<PASS, D>(values, &[]);
    model.run(&run, &p, &mut Passing { width, output });
}

/// The derivatives by any number of parameters, eight a pass.
pub fn in_passes<D: Dynamics>(
    model: &D,
    run: &Experiment,
    values: &[f64],
    free: &[usize],
    output: &mut dyn FnMut(usize, f64, &[f64]),
) {
    let width = free.len();
    if width <= PASS {
        return in_one_pass(model, run, values, free, output);
    }
    let mut angles = vec![f64::NAN; run.len()];
    let mut slopes = vec![f64::NAN; run.len() * width];
    for (pass, some) in free.chunks(PASS).enumerate() {
        in_one_pass(model, run, values, some, &mut |i, angle, slope| {
            angles[i] = angle;
            let start = i * width + pass * PASS;
            slopes[start..start + some.len()].copy_from_slice(slope);
        });
    }
    for (i, angle) in angles.iter().enumerate() {
        output(i, *angle, &slopes[i * width..(i + 1) * width]);
    }
}
