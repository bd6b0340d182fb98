//! Servos of BAM (github.com/Rhoban/bam) as parameter files: its JSON of a fitted model.
//!
//! The file names the kind of servo, of which BAM has supply, gain of the firmware and duty; an
//! export of this program has them in the file.

use std::f64::consts::PI;

use model_core::actuator::{ModelKind, PlantKind, Settings};
use serde_json::{Map, Value};

use super::motor::DrivetrainParameters;
use super::{NotSimulated, resolvable};

/// Kinds of servos with a position loop of the voltage: supply, V, gain of the firmware, duty per
/// gain and error, 1/rad, and the greatest duty.
const SERVOS: [(&str, [f64; 4]); 5] = [
    ("mx64", [15.0, 32.0, 0.158, 0.9625]),
    ("mx106", [15.0, 32.0, 0.158, 0.9625]),
    ("xl320", [7.5, 32.0, 0.050_481_99, 1.0]),
    // 4096 counts a turn, by 256 of the gain and 885 of the duty.
    (
        "xl330",
        [7.5, 400.0, 4096.0 / (2.0 * PI) / (256.0 * 885.0), 1.0],
    ),
    ("sts3215", [7.4, 32.0, 0.166, 0.97]),
];

const DEGREE: f64 = PI / 180.0;

/// Names there, in alternatives, with the names here, factors, and the values where they are
/// absent.
const NAMES: [(&[&str], &str, f64, f64); 14] = [
    (&["kt"], "torque_constant_nm_a", 1.0, f64::NAN),
    (&["R"], "winding_resistance_ohm", 1.0, f64::NAN),
    (&["armature"], "motor_inertia_kg_m2", 1.0, f64::NAN),
    (&["friction_base"], "coulomb_friction_nm", 1.0, f64::NAN),
    (
        &["friction_viscous"],
        "viscous_friction_nm_s_deg",
        DEGREE,
        f64::NAN,
    ),
    (&["friction_stribeck"], "stribeck_friction_nm", 1.0, 0.0),
    (
        &["dtheta_stribeck"],
        "stribeck_rate_deg_s",
        1.0 / DEGREE,
        10.0,
    ),
    (&["alpha"], "stribeck_exponent", 1.0, 1.0),
    (
        &["load_friction_motor", "load_friction_base"],
        "load_friction_motor",
        1.0,
        0.0,
    ),
    (
        &["load_friction_external", "load_friction_base"],
        "load_friction_external",
        1.0,
        0.0,
    ),
    (
        &["load_friction_motor_stribeck", "load_friction_stribeck"],
        "load_stribeck_motor",
        1.0,
        0.0,
    ),
    (
        &["load_friction_external_stribeck", "load_friction_stribeck"],
        "load_stribeck_external",
        1.0,
        0.0,
    ),
    (
        &["load_friction_motor_quad"],
        "load_quadratic_motor_1_nm",
        1.0,
        0.0,
    ),
    (
        &["load_friction_external_quad"],
        "load_quadratic_external_1_nm",
        1.0,
        0.0,
    ),
];

/// Why a file is no servo of BAM that can be simulated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BamError {
    /// It is no JSON.
    #[error("as JSON, a servo of BAM: {0}")]
    Json(String),
    /// A member is missing or is something else.
    #[error("as a servo of BAM: `{name}` is {found}, expected {expected}")]
    Member {
        /// The member.
        name: &'static str,
        /// What it is.
        found: String,
        /// What it has to be.
        expected: String,
    },
    /// The simulator refuses a value.
    #[error("as a servo of BAM: {0}")]
    Parameter(#[from] NotSimulated),
}

/// The text of the parameter file: the bench with the position loop of the servo.
///
/// # Errors
/// [`BamError`].
pub fn text(json: &str) -> Result<String, BamError> {
    let members: Map<String, Value> =
        serde_json::from_str(json).map_err(|error| BamError::Json(error.to_string()))?;
    let wrong = |name, expected: String| BamError::Member {
        name,
        found: members.get(name).map_or("missing".into(), Value::to_string),
        expected,
    };
    let word = |name| members.get(name).and_then(Value::as_str);
    let number = |name: &str| members.get(name).and_then(Value::as_f64);
    let friction = word("model").and_then(|model| model.strip_prefix('m'));
    let friction = friction.and_then(|digit| digit.parse().ok());
    let friction: u8 = friction
        .filter(|model| (1..=6).contains(model))
        .ok_or_else(|| wrong("model", "m1 to m6".into()))?;
    let kind = SERVOS
        .iter()
        .find(|(name, _)| Some(*name) == word("actuator"));
    let names = || SERVOS.map(|(name, _)| name).join(", ");
    let (_, [supply_v, gain, error_gain, greatest]) =
        kind.ok_or_else(|| wrong("actuator", format!("one of {}", names())))?;
    let mut values = vec![("gear_ratio", 1.0), ("backlash_deg", 0.0), ("delay_s", 0.0)];
    for (theirs, ours, factor, absent) in NAMES {
        let value = theirs
            .iter()
            .find_map(|name| number(name))
            .unwrap_or(absent);
        if value.is_nan() {
            return Err(wrong(theirs[0], "a number".into()));
        }
        values.push((ours, value * factor));
    }
    let gain = number("kp").unwrap_or(*gain);
    values.extend([
        ("supply_v", number("vin").unwrap_or(*supply_v)),
        ("firmware_gain", gain),
        ("duty_per_error_pct_deg", 100.0 * error_gain * DEGREE),
        ("duty_limit_pct", 100.0 * greatest),
    ]);
    let drivetrain = DrivetrainParameters::of_servo(friction.into(), values);
    let mut settings = Settings::new(ModelKind::Board, PlantKind::Drivetrain);
    let values = resolvable(&mut settings, drivetrain.values())?;
    let lines = values
        .iter()
        .map(|(name, value, _)| format!("{name} = {value:?}\n"));
    let lines: String = lines.collect();
    Ok(format!(
        "model = \"board\"\nplant = \"bench\"\n\n[set]\n{lines}"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_servo_of_bam_is_the_drivetrain_with_its_values() {
        let json = r#"{"kt": 0.4, "R": 4.0, "armature": 0.002, "friction_base": 0.01,
            "friction_viscous": 0.004, "model": "m1", "actuator": "xl330"}"#;
        let file = text(json).expect("a servo");
        let value = |name: &str| -> f64 {
            let line = file.lines().find(|line| line.starts_with(name));
            let value = line.and_then(|line| line.split(" = ").nth(1));
            value.expect("a parameter").parse().expect("a number")
        };
        let ratio = value("gear_ratio");
        assert!((value("torque_constant_nm_a") * ratio - 0.4).abs() < 1e-12);
        assert!((value("motor_inertia_kg_m2") * ratio * ratio - 0.002).abs() < 1e-12);
        // 885 of the duty at 256 counts by a gain of 885: full duty.
        let full = value("feed_forward_gain") * value("position_gain");
        let counts = 256.0 * 885.0 / 400.0;
        assert!(
            (full * counts * 360.0 / 4096.0 - 100.0).abs() < 1e-9,
            "{full}"
        );
    }

    #[test]
    fn what_is_no_servo_says_what_was_expected() {
        for (json, expected) in [
            ("{", "as JSON"),
            ("{}", "`model` is missing, expected m1 to m6"),
            (r#"{"model": "m7"}"#, r#"`model` is "m7""#),
            (
                r#"{"model": "m1", "actuator": "erob80_50"}"#,
                "expected one of mx64",
            ),
            (r#"{"model": "m1", "actuator": "mx64"}"#, "`kt` is missing"),
        ] {
            let error = text(json).expect_err(json).to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
