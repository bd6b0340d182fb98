//! The models that can be fitted.
//!
//! Each is written once, over [`Scalar`]; its simulation and its sensitivities are the same lines.

mod black_box_1;
mod black_box_2;
mod friction;
mod grey_box;
mod motor;
mod tables;

use std::sync::Arc;

use model_core::parameter::Parameter;

use super::experiment::Experiment;
use super::model::{Model, Sample, State, Sums};
use super::recording::{Recording, RecordingError};
use super::scalar::{Dual, Scalar};

pub use black_box_1::BlackBox1;
pub use black_box_2::{BlackBox2, Form};
pub use grey_box::GreyBox;
pub use motor::{Drive, Motor};

/// A model that is written over [`Scalar`].
pub trait Dynamics: Send + Sync {
    /// As [`Model::name`].
    fn name(&self) -> &'static str;
    /// As [`Model::summary`].
    fn summary(&self) -> &'static str;
    /// As [`Model::parameters`].
    fn parameters(&self) -> &[Parameter];
    /// As [`Model::is_of_the_run`].
    fn is_of_the_run(&self, parameter: usize) -> bool;
    /// As [`Model::is_fixed_by_default`].
    fn is_fixed_by_default(&self, parameter: usize) -> bool;
    /// As [`Model::is_limit`].
    fn is_limit(&self, _parameter: usize) -> bool {
        false
    }
    /// As [`Model::accepts`].
    fn accepts(&self, recording: &Recording) -> Result<(), RecordingError>;
    /// As [`Model::start`].
    fn start(&self, experiments: &[Experiment]) -> Vec<f64>;

    /// As [`Model::special_cases`].
    fn special_cases(&self) -> Vec<Arc<dyn Model>> {
        Vec::new()
    }
    /// As [`Model::neutral`].
    fn neutral(&self, parameter: usize, values: &[f64]) -> f64 {
        values[parameter]
    }

    /// Simulates the run and hands out angle, rate and limit at each sample.
    fn run<S: Scalar>(
        &self,
        run: &Experiment,
        values: &[S],
        seen: &mut impl FnMut(usize, S, f64, State),
    );
}

impl<D: Dynamics> Model for D {
    fn name(&self) -> &'static str {
        Dynamics::name(self)
    }

    fn summary(&self) -> &'static str {
        Dynamics::summary(self)
    }

    fn parameters(&self) -> &[Parameter] {
        Dynamics::parameters(self)
    }

    fn is_of_the_run(&self, parameter: usize) -> bool {
        Dynamics::is_of_the_run(self, parameter)
    }

    fn is_fixed_by_default(&self, parameter: usize) -> bool {
        Dynamics::is_fixed_by_default(self, parameter)
    }

    fn is_limit(&self, parameter: usize) -> bool {
        Dynamics::is_limit(self, parameter)
    }

    fn accepts(&self, recording: &Recording) -> Result<(), RecordingError> {
        Dynamics::accepts(self, recording)
    }

    fn start(&self, experiments: &[Experiment]) -> Vec<f64> {
        Dynamics::start(self, experiments)
    }

    fn special_cases(&self) -> Vec<Arc<dyn Model>> {
        Dynamics::special_cases(self)
    }

    fn neutral(&self, parameter: usize, values: &[f64]) -> f64 {
        Dynamics::neutral(self, parameter, values)
    }

    fn simulate(&self, run: &Experiment, values: &[f64], seen: &mut dyn FnMut(usize, Sample)) {
        self.run(run, values, &mut |i, angle_deg, rate_deg_s, state| {
            seen(
                i,
                Sample {
                    angle_deg,
                    rate_deg_s,
                    state,
                },
            );
        });
    }

    fn sensitivity(
        &self,
        run: &Experiment,
        values: &[f64],
        free: &[usize],
        seen: &mut dyn FnMut(usize, f64, &[f64]),
    ) {
        // Each width is another copy of the model in the program: few, and none too wide.
        match free.len() {
            0..=2 => with_duals::<2, D>(self, run, values, free, seen),
            3..=4 => with_duals::<4, D>(self, run, values, free, seen),
            5..=6 => with_duals::<6, D>(self, run, values, free, seen),
            7..=8 => with_duals::<8, D>(self, run, values, free, seen),
            _ => in_passes(self, run, values, free, seen),
        }
    }

    fn sums(&self, run: &Experiment, values: &[f64], free: &[usize], angles: &[f64]) -> Sums {
        match free.len() {
            0..=2 => sums_with_duals::<2, D>(self, run, values, free, angles),
            3..=4 => sums_with_duals::<4, D>(self, run, values, free, angles),
            5..=6 => sums_with_duals::<6, D>(self, run, values, free, angles),
            7..=8 => sums_with_duals::<8, D>(self, run, values, free, angles),
            _ => sums_in_passes(self, run, values, free, angles),
        }
    }
}

/// The parameters, those of `free` as what derivatives are by.
fn duals<const N: usize>(values: &[f64], free: &[usize]) -> Vec<Dual<N>> {
    let mut duals: Vec<Dual<N>> = values.iter().map(|v| Dual::constant(*v)).collect();
    for (index, parameter) in free.iter().enumerate() {
        duals[*parameter] = Dual::parameter(values[*parameter], index);
    }
    duals
}

/// The sums with a width that the compiler knows: the inner loop of every search.
fn sums_with_duals<const N: usize, D: Dynamics>(
    model: &D,
    run: &Experiment,
    values: &[f64],
    free: &[usize],
    angles: &[f64],
) -> Sums {
    let (mut squares, mut samples) = (0.0, 0);
    let mut products = [0.0; N];
    let mut information = [[0.0; N]; N];
    model.run(run, &duals(values, free), &mut |i, angle: Dual<N>, _, _| {
        if angles[i].is_nan() {
            return;
        }
        let residual = angles[i] - angle.value;
        squares += residual * residual;
        samples += 1;
        for (row, by_row) in angle.slope.iter().enumerate() {
            products[row] += by_row * residual;
            for (place, by_column) in information[row].iter_mut().zip(&angle.slope) {
                *place += by_row * by_column;
            }
        }
    });
    let width = free.len();
    Sums {
        squares,
        samples,
        products: products[..width].to_vec(),
        information: information[..width]
            .iter()
            .flat_map(|row| &row[..width])
            .copied()
            .collect(),
    }
}

/// The sums of more than eight parameters.
fn sums_in_passes<D: Dynamics>(
    model: &D,
    run: &Experiment,
    values: &[f64],
    free: &[usize],
    angles: &[f64],
) -> Sums {
    let mut sums = Sums::new(free.len());
    in_passes(model, run, values, free, &mut |i, angle, slope| {
        if !angles[i].is_nan() {
            sums.add(angles[i] - angle, slope);
        }
    });
    sums
}

/// One pass with all the derivatives.
fn with_duals<const N: usize, D: Dynamics>(
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
fn in_passes<D: Dynamics>(
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

/// The paper's models, simplest first.
pub fn of_the_paper() -> Vec<Arc<dyn Model>> {
    vec![
        Arc::new(BlackBox1::default()),
        Arc::new(BlackBox2::new(Form::Gains)),
        Arc::new(BlackBox2::new(Form::Oscillator)),
        Arc::new(GreyBox::default()),
    ]
}

/// All models, simplest first.
pub fn all() -> Vec<Arc<dyn Model>> {
    let mut all = of_the_paper();
    for drive in [Drive::Duty, Drive::Position] {
        for friction in 1..=6 {
            all.push(Arc::new(Motor::new(drive, friction)));
        }
    }
    all
}

/// The model of this name.
pub fn named(name: &str) -> Option<Arc<dyn Model>> {
    all().into_iter().find(|model| model.name() == name)
}

#[cfg(test)]
mod tests;
