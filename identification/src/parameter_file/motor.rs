//! Motors and servos as the drivetrain of the simulator.

use model_core::plant::drivetrain::gear_train::GearTrainParameters;

use super::Set;
use crate::fit::{Estimate, Fit};

/// A fitted motor or servo.
pub(super) struct DrivetrainParameters<'a> {
    /// By the names of the fitted model: those that all recordings share, and what is known of the
    /// first one.
    parameters: Vec<(&'a str, f64, Option<&'a Estimate>)>,
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
        let is_first = |e: &&Estimate| e.fixed && e.experiment == Some(0);
        let given = |e: &&Estimate| e.experiment.is_none() || is_first(e);
        Some(Self {
            parameters: fit
                .estimates
                .iter()
                .filter(given)
                .map(|e| (e.name, e.value, Some(e)))
                .collect(),
            friction_model,
            is_servo,
        })
    }

    /// The drivetrain of a servo with these parameters.
    pub fn of_servo(friction_model: f64, values: impl IntoIterator<Item = (&'a str, f64)>) -> Self {
        let values = values.into_iter();
        Self {
            parameters: values.map(|(name, value)| (name, value, None)).collect(),
            friction_model,
            is_servo: true,
        }
    }

    fn found(&self, name: &str) -> Option<(f64, Option<&'a Estimate>)> {
        let mut parameters = self.parameters.iter();
        let found = parameters.find(|(known, ..)| *known == name);
        found.map(|(_, value, estimate)| (*value, *estimate))
    }

    fn value(&self, name: &str) -> f64 {
        self.found(name).map_or(f64::NAN, |(value, _)| value)
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
        let estimates = self
            .parameters
            .iter()
            .filter_map(|(.., estimate)| *estimate);
        for of_run in estimates.filter(|e| e.experiment.is_some()) {
            remarks.push(format!(
                "The recordings have different values of {}: here that of the first, {:?}.",
                of_run.name, of_run.value
            ));
        }
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
            let (value, estimate) = self.found(name)?;
            Some((name, value, estimate))
        });
        values.extend(alike);
        values.extend(ABSENT.map(|(name, value)| (name, value, None)));
        let stop = self.found("hard_stop_deg");
        let stop = stop.filter(|(stop_deg, _)| stop_deg.is_finite());
        values.extend(stop.map(|(stop_deg, estimate)| ("hard_stop_deg", stop_deg, estimate)));
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
