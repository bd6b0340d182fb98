//! Friction of the gear train: models M1 to M6 of Duclusaud, Passault et al., "Extended Friction
//! Models for the Physics Simulation of Servo Actuators", arXiv 2410.08650.
//!
//! Each model defines a budget: the maximum torque with which friction can oppose motion. With the
//! Stribeck factor `s`, the external torque `te` on the gear train and the motor torque `tm`, both
//! at the output and with the same sign convention,
//!
//! ```text
//! budget = Kc + Kv |w|                                       M1 Coulomb and viscous
//!        + s Ks                  s = exp(-|w/ws|^a)          M2 Stribeck
//!        + k |te - tm|                                       M3 load-dependent
//!        + s Ks + (k + s ks) |te - tm|                       M4 load-dependent with Stribeck
//!        + s Ks + |ke te - km tm| + s |kes te - kms tm|      M5 directional
//!        + s q                                               M6 quadratic, while te and tm oppose:
//!                                q = qe te^2 where |te| < |tm|, qm tm^2 where |te| > |tm|
//! ```
//!
//! The other models are M6 with some coefficients zero or equal, and are computed as such. The
//! friction torque is the torque that would stop the motion within the step, limited to the budget
//! ([`Friction`] calculates the budget, the gear train applies it): a body at rest remains exactly
//! at rest.

use core::f64::consts::PI;

crate::parameters! {
    /// Friction of the gearbox and everything before it, at the output shaft.
    pub struct FrictionParameters {
        /// Friction model M1 to M6; a fraction is truncated.
        friction_model [""]: 1.0, "choice", 1.0, 6.0, "the simplest";
        /// Coulomb friction `Kc`.
        coulomb_friction_nm [""]: 0.028, "Nm", 0.0, 10.0, "estimate: with the bearing's, 3 % of the stall torque";
        /// Viscous friction `Kv`.
        viscous_friction_nm_s_deg [""]: 3.5e-5, "Nm s/deg", 0.0, 1.0, "estimate: 1 % of the damping by back-EMF";
        /// Breakaway friction in addition to the Coulomb friction, `Ks`.
        stribeck_friction_nm [""]: 0.015, "Nm", 0.0, 10.0, "estimate: half the Coulomb friction";
        /// Rate `ws` at which the Stribeck factor has fallen to 1/e.
        stribeck_rate_deg_s [""]: 11.5, "deg/s", 0.01, 1000.0, "arXiv 2410.08650, the authors' starting value of 0.2 rad/s";
        /// Exponent `a` of the Stribeck factor.
        stribeck_exponent [""]: 1.35, "1", 0.1, 10.0, "arXiv 2410.08650, the authors' starting value";
        /// Friction per motor torque, `km`; `k` of M3 and M4.
        load_friction_motor [""]: 0.05, "1", 0.0, 1.0, "arXiv 2410.08650, the authors' starting value";
        /// Friction per external torque, `ke`.
        load_friction_external [""]: 0.05, "1", 0.0, 1.0, "arXiv 2410.08650, the authors' starting value";
        /// Additional friction at rest per motor torque, `kms`; `ks` of M4.
        load_stribeck_motor [""]: 0.05, "1", 0.0, 1.0, "arXiv 2410.08650, the authors' starting value";
        /// Additional friction at rest per external torque, `kes`.
        load_stribeck_external [""]: 0.05, "1", 0.0, 1.0, "arXiv 2410.08650, the authors' starting value";
        /// Quadratic friction of the motor torque, `qm`.
        load_quadratic_motor_1_nm [""]: 0.01, "1/Nm", 0.0, 10.0, "arXiv 2410.08650, top of the authors' range";
        /// Quadratic friction of the external torque, `qe`.
        load_quadratic_external_1_nm [""]: 0.01, "1/Nm", 0.0, 10.0, "arXiv 2410.08650, top of the authors' range";
    }
}

/// The budget of M1.
#[inline(always)]
pub(super) fn viscous_nm(coulomb_nm: f64, viscous_nm_s: f64, rate_rad_s: f64) -> f64 {
    coulomb_nm + viscous_nm_s * rate_rad_s.abs()
}

/// The friction budget.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Friction {
    #[cfg_attr(feature = "serde", serde(with = "crate::parameter::as_values"))]
    coefficients: FrictionParameters,
    viscous_nm_s: f64,
    stribeck_rad_s: f64,
    /// Whether all terms but those of M1 are zero.
    is_viscous: bool,
}

impl Friction {
    /// The model selected by the parameters, whose ranges are not checked.
    ///
    /// ```
    /// use model_core::plant::drivetrain::friction::{Friction, FrictionParameters};
    ///
    /// let friction = Friction::new(FrictionParameters {
    ///     friction_model: 3.0, coulomb_friction_nm: 0.1, load_friction_motor: 0.5,
    ///     ..Default::default()
    /// });
    /// assert_eq!(friction.budget_nm(0.0, 1.0, -1.0), 0.1 + 0.5 * 2.0);
    /// ```
    pub fn new(mut p: FrictionParameters) -> Self {
        let model = p.friction_model;
        let has = |condition, value: f64| if condition { value } else { 0.0 };
        let is_directional = model >= 5.0;
        if !is_directional {
            p.load_friction_external = p.load_friction_motor;
            p.load_stribeck_external = p.load_stribeck_motor;
        }
        let has_stribeck = model >= 4.0 || (2.0..3.0).contains(&model);
        p.stribeck_friction_nm = has(has_stribeck, p.stribeck_friction_nm);
        p.load_friction_motor = has(model >= 3.0, p.load_friction_motor);
        p.load_friction_external = has(model >= 3.0, p.load_friction_external);
        p.load_stribeck_motor = has(model >= 4.0, p.load_stribeck_motor);
        p.load_stribeck_external = has(model >= 4.0, p.load_stribeck_external);
        p.load_quadratic_motor_1_nm = has(model >= 6.0, p.load_quadratic_motor_1_nm);
        p.load_quadratic_external_1_nm = has(model >= 6.0, p.load_quadratic_external_1_nm);
        Self {
            coefficients: p,
            viscous_nm_s: p.viscous_friction_nm_s_deg * (180.0 / PI),
            stribeck_rad_s: p.stribeck_rate_deg_s * (PI / 180.0),
            is_viscous: [
                p.stribeck_friction_nm,
                p.load_friction_motor,
                p.load_friction_external,
                p.load_stribeck_motor,
                p.load_stribeck_external,
                p.load_quadratic_motor_1_nm,
                p.load_quadratic_external_1_nm,
            ] == [0.0; 7],
        }
    }

    /// The maximum friction torque at an output rate, rad/s, with the motor torque and the external
    /// torque at the output, Nm.
    #[inline]
    pub fn budget_nm(&self, rate_rad_s: f64, motor_nm: f64, external_nm: f64) -> f64 {
        let p = &self.coefficients;
        if self.is_viscous {
            return viscous_nm(p.coulomb_friction_nm, self.viscous_nm_s, rate_rad_s);
        }
        let load = |external: f64, motor: f64| (external * external_nm - motor * motor_nm).abs();
        let at_rest_nm = p.stribeck_friction_nm
            + load(p.load_stribeck_external, p.load_stribeck_motor)
            + self.quadratic_nm(motor_nm, external_nm);
        viscous_nm(p.coulomb_friction_nm, self.viscous_nm_s, rate_rad_s)
            + load(p.load_friction_external, p.load_friction_motor)
            + self.stribeck_nm(rate_rad_s, at_rest_nm)
    }

    /// Coulomb friction, Nm, and viscous friction, Nm s, where these are all there is.
    pub(super) fn viscous(&self) -> Option<(f64, f64)> {
        self.is_viscous
            .then_some((self.coefficients.coulomb_friction_nm, self.viscous_nm_s))
    }

    /// `s` times a torque: the full torque at rest, decreasing with the rate.
    fn stribeck_nm(&self, rate_rad_s: f64, at_rest_nm: f64) -> f64 {
        // The power function is the most expensive part of a step, and often not needed.
        if rate_rad_s == 0.0 || at_rest_nm == 0.0 {
            return at_rest_nm;
        }
        let ratio = (rate_rad_s / self.stribeck_rad_s).abs();
        at_rest_nm * libm::exp(-libm::pow(ratio, self.coefficients.stribeck_exponent))
    }

    fn quadratic_nm(&self, motor_nm: f64, external_nm: f64) -> f64 {
        let p = &self.coefficients;
        if motor_nm * external_nm >= 0.0 {
            0.0
        } else if external_nm.abs() < motor_nm.abs() {
            p.load_quadratic_external_1_nm * external_nm * external_nm
        } else if external_nm.abs() > motor_nm.abs() {
            p.load_quadratic_motor_1_nm * motor_nm * motor_nm
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Budget at the Stribeck rate of 10 deg/s, where s = 1/e, with a motor torque of 2 Nm and an
    /// external torque of -1 Nm.
    fn budget(model: f64) -> f64 {
        let friction = Friction::new(FrictionParameters {
            friction_model: model,
            coulomb_friction_nm: 0.1,
            viscous_friction_nm_s_deg: 0.002,
            stribeck_friction_nm: 0.2,
            stribeck_rate_deg_s: 10.0,
            stribeck_exponent: 2.0,
            load_friction_motor: 0.03,
            load_friction_external: 0.04,
            load_stribeck_motor: 0.05,
            load_stribeck_external: 0.06,
            load_quadratic_motor_1_nm: 0.07,
            load_quadratic_external_1_nm: 0.08,
        });
        friction.budget_nm(-10.0 * PI / 180.0, 2.0, -1.0)
    }

    #[test]
    fn the_budgets_of_the_six_models_match_hand_calculation() {
        let s = libm::exp(-1.0);
        let m1 = 0.1 + 0.02;
        let by_hand = [
            m1,
            m1 + s * 0.2,
            m1 + 0.03 * 3.0,
            m1 + 0.03 * 3.0 + s * (0.2 + 0.05 * 3.0),
            m1 + 0.1 + s * (0.2 + 0.16),
            m1 + 0.1 + s * (0.2 + 0.16 + 0.08),
        ];
        for (i, expected) in by_hand.iter().enumerate() {
            let model = i as f64 + 1.0;
            assert!((budget(model) - expected).abs() < 1e-15, "M{model}");
            assert_eq!(budget(model), budget((model + 0.5).min(6.0)));
        }
    }

    #[test]
    fn the_quadratic_term_uses_the_smaller_of_opposing_torques() {
        let friction = Friction::new(FrictionParameters {
            friction_model: 6.0,
            coulomb_friction_nm: 0.0,
            stribeck_friction_nm: 0.0,
            load_friction_motor: 0.0,
            load_friction_external: 0.0,
            load_stribeck_motor: 0.0,
            load_stribeck_external: 0.0,
            load_quadratic_motor_1_nm: 0.5,
            load_quadratic_external_1_nm: 0.25,
            ..Default::default()
        });
        assert_eq!(friction.budget_nm(0.0, 3.0, -2.0), 0.25 * 4.0);
        assert_eq!(friction.budget_nm(0.0, 2.0, -3.0), 0.5 * 4.0);
        assert_eq!(friction.budget_nm(0.0, 2.0, 3.0), 0.0);
    }
}
