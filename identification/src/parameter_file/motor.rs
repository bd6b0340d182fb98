//! Motors and servos as the drivetrain of the simulator.

use model_core::plant::drivetrain::gear_train::GearTrainParameters;

use super::Set;
use crate::fit::{Estimate, Fit};

/// A fitted motor or servo.
pub(super) struct DrivetrainParameters<'a> {
    fit: &'a Fit,
    friction_model: f64,
    is_servo: bool,
}

/// Parameters with the same name and meaning in the drivetrain.
const ALIKE: [&str; 19] = [
    "winding_resistance_ohm",
    "supply_v",
    "delay_s",
    "duty_limit_pct",
    "pendulum_mass_kg",
    "pendulum_length_m",
    "load_torque_nm",
    "backlash_deg",
    "coulomb_friction_nm",
    "viscous_friction_nm_s_deg",
    "stribeck_friction_nm",
    "stribeck_rate_deg_s",
    "stribeck_exponent",
    "load_friction_motor",
    "load_friction_external",
    "load_stribeck_motor",
    "load_stribeck_external",
    "load_quadratic_motor_1_nm",
    "load_quadratic_external_1_nm",
];

/// Parameters that the fitted model lacks, with their values.
const ABSENT: [(&str, f64); 2] = [("bearing_friction_nm", 0.0), ("winding_inductance_h", 0.0)];

/// Gain of the position loop, 1/s. Its value is arbitrary: the feed-forward gain divides by it.
const POSITION_GAIN: f64 = 10.0;

/// Parameters that the simulator does not have.
const UNKNOWN: [&str; 2] = ["vertical_deg", "drive_asymmetry"];

/// Whether the model of this name is a servo, and its friction model; `None` where it is not a
/// motor.
pub(super) fn form(model: &str) -> Option<(bool, f64)> {
    let (kind, friction) = model.split_once("-m")?;
    let is_servo = match kind {
        "motor" => false,
        "servo" => true,
        _ => return None,
    };
    Some((is_servo, friction.parse().ok()?))
}

impl<'a> DrivetrainParameters<'a> {
    /// The drivetrain of a fit; `None` where it is not a motor.
    pub fn of(fit: &'a Fit) -> Option<Self> {
        let (is_servo, friction_model) = form(fit.model)?;
        Some(Self {
            fit,
            friction_model,
            is_servo,
        })
    }

    fn shared(&self, name: &str) -> Option<&'a Estimate> {
        let estimates = self.fit.estimates.iter();
        let mut shared = estimates.filter(|e| e.experiment.is_none());
        shared.find(|e| e.name == name)
    }

    fn value(&self, name: &str) -> f64 {
        self.shared(name).map_or(f64::NAN, |e| e.value)
    }

    /// Remarks in the file.
    pub fn remarks(&self) -> Vec<String> {
        let mut remarks = vec![
            match self.is_servo {
                true => {
                    "The position loop is the fitted one: duty per error by feed-forward alone."
                }
                false => "The motor alone was fitted: the loops around it are the board's own.",
            }
            .to_owned(),
        ];
        for name in UNKNOWN {
            let value = self.value(name);
            if value != 0.0 && value.is_finite() {
                remarks.push(format!("Not simulated: {name} = {value:?}"));
            }
        }
        remarks
    }

    /// The parameters of the drivetrain.
    pub fn values(&self) -> Vec<Set<'a>> {
        // Referred to the output shaft, and from there to a gear ratio in the drivetrain's range.
        let fitted_ratio = self.value("gear_ratio");
        let ratio = fitted_ratio.max(GearTrainParameters::default().gear_ratio);
        let scale = fitted_ratio / ratio;
        let mut values: Vec<Set<'a>> = vec![
            ("friction_model", self.friction_model, None),
            ("gear_ratio", ratio, None),
            (
                "torque_constant_nm_a",
                self.value("torque_constant_nm_a") * scale,
                None,
            ),
            (
                "motor_inertia_kg_m2",
                self.value("motor_inertia_kg_m2") * scale * scale,
                None,
            ),
        ];
        // The delay of a motor is between duty and torque, and not a transport delay of the
        // command.
        let is_of_the_servo = |name: &&str| self.is_servo || *name != "delay_s";
        let alike = ALIKE.into_iter().filter(is_of_the_servo);
        let alike = alike.filter_map(|name| {
            let estimate = self.shared(name)?;
            Some((name, estimate.value, Some(estimate)))
        });
        values.extend(alike);
        values.extend(ABSENT.map(|(name, value)| (name, value, None)));
        let stop_deg = self.value("hard_stop_deg");
        if stop_deg.is_finite() {
            values.push(("hard_stop_deg", stop_deg, self.shared("hard_stop_deg")));
        }
        if self.is_servo {
            values.extend(self.position_loop());
        }
        values
    }

    /// `u = Kff P (command - angle)`, without a rate loop and without an integrator.
    fn position_loop(&self) -> impl Iterator<Item = Set<'a>> {
        let gain = self.value("duty_per_error_pct_deg") * self.value("firmware_gain");
        let set = [
            ("position_gain", POSITION_GAIN),
            ("feed_forward_gain", gain / POSITION_GAIN),
            ("proportional_gain", 0.0),
            ("integral_gain", 0.0),
            ("anti_windup_gain", 0.0),
        ];
        set.into_iter().map(|(name, value)| (name, value, None))
    }
}
