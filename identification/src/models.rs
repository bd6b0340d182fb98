//! The models that can be fitted.
//!
//! Each model is written once over [`Scalar`]: its simulation and its sensitivities are the same
//! code. A new model is one file with a struct of parameters (`parameters!`), an implementation of
//! [`Description`] and [`Dynamics`] and a function `models`; it is registered in the list
//! `FAMILIES` below, and the command line, the comparison and Python offer it by its name.

mod black_box_1;
mod black_box_2;
mod friction;
mod grey_box;
mod initial_state;
mod limits;
mod motor;
mod sensitivity;

use std::ops::Range;
use std::sync::Arc;

use super::experiment::Experiment;
use super::hybrid::Output;
use super::model::{COMMANDS_PER_PASS, Description, Model, ParameterValues, Sample, Sums};
use super::scalar::Scalar;
use sensitivity::{by_command, in_passes, sums_in_passes, sums_with_duals};

pub use black_box_1::BlackBox1;
pub(crate) use black_box_2::gains as oscillator_gains;
pub use black_box_2::{BlackBox2, BlackBox2Oscillator};
pub use grey_box::GreyBox;
pub use motor::{Drive, Motor};

/// A family of models, with whether it is one of the paper's.
type Family = (fn() -> Vec<Arc<dyn Model>>, bool);

/// All models, simplest first.
const FAMILIES: [Family; 4] = [
    (black_box_1::models, true),
    (black_box_2::models, true),
    (grey_box::models, true),
    (motor::models, false),
];

/// The equations of a model, written over [`Scalar`].
pub trait Dynamics: Description {
    /// Its parameters by name.
    type Parameters<S: Scalar>: ParameterValues<S>;

    /// Starting values from a regression over the recordings.
    fn start(&self, experiments: &[Experiment]) -> Self::Parameters<f64>;

    /// Simulates the run and passes angle, rate and active limit of each sample to `output`.
    fn run<S: Scalar>(
        &self,
        run: &Experiment,
        p: &Self::Parameters<S>,
        output: &mut impl Output<S>,
    );
}

impl<D: Dynamics> Model for D {
    fn starting_values(&self, experiments: &[Experiment]) -> Vec<f64> {
        self.start(experiments).to_vec()
    }

    fn simulate(&self, run: &Experiment, values: &[f64], output: &mut dyn FnMut(usize, Sample)) {
        let p = D::Parameters::from_slice(values);
        self.run(run, &p, &mut |i, angle_deg: f64, rate_deg_s, state| {
            output(
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
        output: &mut dyn FnMut(usize, f64, &[f64]),
    ) {
        in_passes(self, run, values, free, output);
    }

    fn command_sensitivity(
        &self,
        run: &Experiment,
        values: &[f64],
        segments: Range<usize>,
        output: &mut dyn FnMut(usize, f64, &[f64]),
    ) {
        let end = segments.end.min(segments.start + COMMANDS_PER_PASS);
        by_command(self, run, values, segments.start..end, output);
    }

    fn sums(&self, run: &Experiment, values: &[f64], free: &[usize], angles: &[f64]) -> Sums {
        // Each width is another copy of the model in the program: few, and none too wide.
        match free.len() {
            0 => sums_with_duals::<0, D>(self, run, values, free, angles),
            1..=2 => sums_with_duals::<2, D>(self, run, values, free, angles),
            3..=4 => sums_with_duals::<4, D>(self, run, values, free, angles),
            5..=6 => sums_with_duals::<6, D>(self, run, values, free, angles),
            7..=8 => sums_with_duals::<8, D>(self, run, values, free, angles),
            _ => sums_in_passes(self, run, values, free, angles),
        }
    }
}

/// The paper's models, simplest first.
pub fn of_the_paper() -> Vec<Arc<dyn Model>> {
    let families = FAMILIES
        .iter()
        .filter(|(_, is_of_the_paper)| *is_of_the_paper);
    families.flat_map(|(models, _)| models()).collect()
}

/// All models, simplest first.
pub fn all() -> Vec<Arc<dyn Model>> {
    FAMILIES.iter().flat_map(|(models, _)| models()).collect()
}

/// The model of this name.
pub fn named(name: &str) -> Option<Arc<dyn Model>> {
    all().into_iter().find(|model| model.name() == name)
}

#[cfg(test)]
mod tests;
