//! The friction budgets M1 to M6 of [`model_core::plant::drivetrain::friction`] over [`Scalar`]:
//! the search needs their derivatives.

use super::motor::MotorValues;
use crate::model::NestedOptimum;
use crate::scalar::Scalar;

/// The coefficients by name, each with the friction models 1 to 6 that have it. M3 lacks the
/// Stribeck term of M2.
const COEFFICIENTS: [(&str, [bool; 6]); 11] = {
    const ALL: [bool; 6] = [true; 6];
    const STRIBECK: [bool; 6] = [false, true, false, true, true, true];
    const LOAD: [bool; 6] = [false, false, true, true, true, true];
    const LOAD_STRIBECK: [bool; 6] = [false, false, false, true, true, true];
    const DIRECTIONAL: [bool; 6] = [false, false, false, false, true, true];
    const QUADRATIC: [bool; 6] = [false, false, false, false, false, true];
    [
        ("coulomb_friction_nm", ALL),
        ("viscous_friction_nm_s_deg", ALL),
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

/// Whether the parameter of this name is a friction coefficient.
pub fn is_coefficient(name: &str) -> bool {
    COEFFICIENTS
        .iter()
        .any(|(coefficient, _)| *coefficient == name)
}

/// Whether friction model `model`, 1 to 6, has a parameter; every model has those that are no
/// friction coefficients.
pub fn has_coefficient(model: usize, name: &str) -> bool {
    let mut coefficients = COEFFICIENTS.iter();
    let found = coefficients.find(|(coefficient, _)| *coefficient == name);
    found.is_none_or(|(_, models)| models[(model - 1).min(5)])
}

/// The value of a coefficient with which a model reproduces a nested one that lacks it.
pub fn neutral_value(name: &str, nested: &NestedOptimum<'_>) -> Option<f64> {
    match name {
        // Without a Stribeck term its rate and exponent have no effect.
        "stribeck_rate_deg_s" | "stribeck_exponent" => nested.value(name),
        // The same coefficient for both torques.
        "load_friction_external" => nested.value("load_friction_motor"),
        "load_stribeck_external" => nested.value("load_stribeck_motor"),
        _ => Some(0.0),
    }
}

/// A friction budget; terms that its model lacks are zero.
#[derive(Clone, Copy)]
pub struct Friction<S> {
    coulomb: S,
    /// Viscous friction, Nm s/rad.
    pub viscous_nm_s: S,
    has_stribeck: bool,
    stribeck: S,
    stribeck_rad_s: S,
    exponent: S,
    load: [S; 2],
    load_stribeck: [S; 2],
    quadratic: [S; 2],
}

impl<S: Scalar> Friction<S> {
    /// The budget of model `model`; the coefficients that it lacks are zero.
    pub fn new(model: usize, p: &MotorValues<S>) -> Self {
        let term = |name: &str, value: S| match has_coefficient(model, name) {
            true => value,
            false => S::constant(0.0),
        };
        // Models without a directional coefficient use one coefficient for both torques.
        let is_directional = has_coefficient(model, "load_friction_external");
        let pair = |name: &str, motor: S, external: S| {
            let external = if is_directional { external } else { motor };
            [term(name, motor), term(name, external)]
        };
        let degree = std::f64::consts::PI / 180.0;
        Self {
            coulomb: p.coulomb_friction_nm,
            viscous_nm_s: p.viscous_friction_nm_s_deg * (1.0 / degree),
            has_stribeck: has_coefficient(model, "stribeck_friction_nm"),
            stribeck: term("stribeck_friction_nm", p.stribeck_friction_nm),
            stribeck_rad_s: p.stribeck_rate_deg_s * degree,
            exponent: p.stribeck_exponent,
            load: pair(
                "load_friction_motor",
                p.load_friction_motor,
                p.load_friction_external,
            ),
            load_stribeck: pair(
                "load_stribeck_motor",
                p.load_stribeck_motor,
                p.load_stribeck_external,
            ),
            quadratic: [p.load_quadratic_motor_1_nm, p.load_quadratic_external_1_nm]
                .map(|value| term("load_quadratic_motor_1_nm", value)),
        }
    }

    /// The greatest torque of friction, Nm, as
    /// [`budget_nm`](model_core::plant::drivetrain::friction::Friction::budget_nm), without the
    /// viscous one, which has no jump.
    pub fn budget_nm(&self, rate_rad_s: S, motor_nm: S, external_nm: S) -> S {
        let of_load = |[motor, external]: [S; 2]| (external * external_nm - motor * motor_nm).abs();
        let moving = self.coulomb + of_load(self.load);
        if !self.has_stribeck {
            return moving;
        }
        let at_rest =
            self.stribeck + of_load(self.load_stribeck) + self.quadratic_nm(motor_nm, external_nm);
        moving + at_rest * self.share(rate_rad_s)
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
    use crate::model::ParameterValues;
    use model_core::parameter::Parameters;
    use model_core::plant::drivetrain::friction::{
        Friction as SimulatedFriction, FrictionParameters,
    };
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
                let mut values = MotorValues::<f64>::defaults().to_vec();
                for (name, _) in COEFFICIENTS {
                    let mut table = MotorValues::<f64>::TABLE.iter();
                    let index = table
                        .position(|row| row.name == name)
                        .expect("a coefficient");
                    values[index] *= noise.gaussian(0.5).exp();
                    p.set(name, values[index]).expect("a coefficient");
                }
                let values = MotorValues::from_slice(&values);
                let [rate, motor, external] = [0.3, 1.0, 1.0].map(|d| noise.gaussian(d));
                let expected = SimulatedFriction::new(p).budget_nm(rate, motor, external);
                let friction = Friction::new(model, &values);
                let viscous = friction.viscous_nm_s * rate.abs();
                let budget = friction.budget_nm(rate, motor, external) + viscous;
                assert!(
                    (budget - expected).abs() < 1e-12,
                    "M{model}: {budget} {expected}"
                );
            }
        }
    }
}
