//! The models that can be fitted.
//!
//! Each is written once, over [`Scalar`]; its simulation and its sensitivities are the same lines.

mod black_box_1;
mod black_box_2;
mod friction;
mod grey_box;
mod limits;
mod motor;
mod passes;
mod tables;

use std::sync::Arc;

use super::experiment::Experiment;
use super::flow::Watch;
use super::model::{Description, Model, Sample, Sums};
use super::scalar::Scalar;
use passes::{in_passes, sums_in_passes, sums_with_duals, with_duals};

pub use black_box_1::BlackBox1;
pub use black_box_2::{BlackBox2, Form};
pub use grey_box::GreyBox;
pub use motor::{Drive, Motor};

/// A model that is written over [`Scalar`].
pub trait Dynamics: Description {
    /// Simulates the run and hands out angle, rate and limit at each sample.
    fn run<S: Scalar>(&self, run: &Experiment, values: &[S], seen: &mut impl Watch<S>);
}

impl<D: Dynamics> Model for D {
    fn simulate(&self, run: &Experiment, values: &[f64], seen: &mut dyn FnMut(usize, Sample)) {
        self.run(run, values, &mut |i, angle_deg: f64, rate_deg_s, state| {
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
