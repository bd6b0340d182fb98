//! The friction budgets M1 to M6 of [`model_core::plant::drivetrain::friction`], over [`Scalar`]: the
//! search needs their derivatives.

use model_core::parameter::{Parameter, Parameters};
use model_core::plant::drivetrain::friction::FrictionParameters;

use crate::scalar::Scalar;

/// Names of the coefficients, in the order of [`Friction::new`], each with the first model that
/// has it. M3 is without the Stribeck share of M2.
const COEFFICIENTS: [(&str, [bool; 6]); 11] = {
    const FROM_1: [bool; 6] = [true; 6];
    const STRIBECK: [bool; 6] = [false, true, false, true, true, true];
    const LOAD: [bool; 6] = [false, false, true, true, true, true];
    const LOAD_STRIBECK: [bool; 6] = [false, false, false, true, true, true];
    const DIRECTIONAL: [bool; 6] = [false, false, false, false, true, true];
    const QUADRATIC: [bool; 6] = [false, false, false, false, false, true];
    [
        ("coulomb_friction_nm", FROM_1),
        ("viscous_friction_nm_s_deg", FROM_1),
        ("stribeck_friction_nm", STRIBECK),
        ("stribeck_rate_deg_s", STRIBECK),
        ("stribeck_exponent", STRIBECK),
        ("load_friction_motor", LOAD),
        ("load_friction_external", DIRECTIONAL),
        ("load_stribeck_motor", LOAD_STRIBECK),
        ("load_stribeck_external", DIRECTIONAL),
        ("load_quadratic_motor_1_nm", QUADRATIC),
        ("load_quadratic_external_1_nm", QUADRATIC),
    ]
};

/// How many coefficients a table of all of them has.
pub const COUNT: usize = COEFFICIENTS.len();

/// The coefficients, and whether friction model `model`, 1 to 6, has each.
pub fn coefficients(model: usize) -> impl Iterator<Item = (Parameter, bool)> {
    COEFFICIENTS.iter().map(move |(name, models)| {
        let row = FrictionParameters::TABLE.iter().find(|p| p.name == *name);
        let row = *row.unwrap_or_else(|| panic!("no coefficient {name} in the table"));
        (row, models[(model - 1).min(5)])
    })
}

/// Within what a coefficient of a small servo lies, where that is narrower than what it can be: the
/// ranges in which the authors of arXiv 2410.08650 search (github.com/Rhoban/bam, `bam/model.py`).
/// Beyond them a recording is met by frictions that no servo has, and one that is left out is not.
pub fn usual_bounds(coefficient: usize) -> Option<(f64, f64)> {
    const DEGREE: f64 = std::f64::consts::PI / 180.0;
    match coefficient {
        // Up to 1 Nm s/rad.
        1 => Some((0.0, DEGREE)),
        // 0.1 to 1 rad/s.
        3 => Some((0.1 / DEGREE, 1.0 / DEGREE)),
        4 => Some((1.0, 10.0)),
        // Shares of the torques in motion, and of their squares at rest.
        5 | 6 => Some((0.0, 0.5)),
        9 | 10 => Some((0.0, 0.01)),
        _ => None,
    }
}

/// The value of a coefficient with which a model is the one before it, that has these values.
pub fn neutral(coefficient: usize, values: &[f64]) -> f64 {
    match coefficient {
        // Without a Stribeck share, its rate and exponent do nothing.
        3 | 4 => values[coefficient],
        // One for both torques.
        6 | 8 => values[coefficient - 1],
        _ => 0.0,
    }
}

/// A friction budget; what its model does not have is zero.
#[derive(Clone, Copy)]
pub struct Friction<S> {
    coulomb: S,
    viscous_nm_s: S,
    stribeck: S,
    stribeck_rad_s: S,
    exponent: S,
    load: [S; 2],
    load_stribeck: [S; 2],
    quadratic: [S; 2],
}

impl<S: Scalar> Friction<S> {
    /// The budget of model `model` with these coefficients, in their order.
    pub fn new(model: usize, values: &[S]) -> Self {
        let has = |index: usize| COEFFICIENTS[index].1[(model - 1).min(5)];
        let some = |index: usize| {
            if has(index) {
                values[index]
            } else {
                S::constant(0.0)
            }
        };
        // One coefficient for both torques where the model makes no difference.
        let pair = |motor: usize, external: usize| {
            let external = if has(external) { external } else { motor };
            [some(motor), some(external)]
        };
        let degree = std::f64::consts::PI / 180.0;
        Self {
            coulomb: some(0),
            viscous_nm_s: some(1) * (1.0 / degree),
            stribeck: some(2),
            stribeck_rad_s: values[3] * degree,
            exponent: values[4],
            load: pair(5, 6),
            load_stribeck: pair(7, 8),
            quadratic: [some(9), some(10)],
        }
    }

    /// The greatest torque of friction, Nm, as
    /// [`budget_nm`](model_core::plant::drivetrain::friction::Friction::budget_nm).
    pub fn budget_nm(&self, rate_rad_s: S, motor_nm: S, external_nm: S) -> S {
        let of_load = |[motor, external]: [S; 2]| (external * external_nm - motor * motor_nm).abs();
        let at_rest =
            self.stribeck + of_load(self.load_stribeck) + self.quadratic_nm(motor_nm, external_nm);
        self.coulomb
            + self.viscous_nm_s * rate_rad_s.abs()
            + of_load(self.load)
            + at_rest * self.share(rate_rad_s)
    }

    /// The Stribeck share `exp(-|w/ws|^a)`.
    fn share(&self, rate_rad_s: S) -> S {
        let ratio = (rate_rad_s / self.stribeck_rad_s).abs();
        if ratio.value() == 0.0 {
            return S::constant(1.0);
        }
        (-(self.exponent * ratio.ln()).exp()).exp()
    }

    fn quadratic_nm(&self, motor_nm: S, external_nm: S) -> S {
        let [by_motor, by_external] = self.quadratic;
        let (motor, external) = (motor_nm.value(), external_nm.value());
        if motor * external >= 0.0 || motor.abs() == external.abs() {
            S::constant(0.0)
        } else if external.abs() < motor.abs() {
            by_external * external_nm * external_nm
        } else {
            by_motor * motor_nm * motor_nm
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use model_core::plant::drivetrain::friction::Friction as OfTheSimulator;
    use model_core::sensors::noise::Noise;

    #[test]
    fn the_budgets_are_those_of_the_simulator() {
        let mut noise = Noise::new(5, 0);
        for model in 1..=6 {
            for _ in 0..200 {
                let mut p = FrictionParameters {
                    friction_model: model as f64,
                    ..Default::default()
                };
                let mut values = Vec::new();
                for (row, _) in coefficients(model) {
                    let value = row.default * noise.gaussian(0.5).exp();
                    p.set(row.name, value).expect("a coefficient");
                    values.push(value);
                }
                let [rate, motor, external] = [0.3, 1.0, 1.0].map(|d| noise.gaussian(d));
                let expected = OfTheSimulator::new(p).budget_nm(rate, motor, external);
                let budget = Friction::new(model, &values).budget_nm(rate, motor, external);
                assert!(
                    (budget - expected).abs() < 1e-12,
                    "M{model}: {budget} {expected}"
                );
            }
        }
    }
}
