//! A motor that is none of those near the paper's: that of a servo of another maker, with an eighth
//! of the inertia, two fifths of the torque constant and friction by the torque of the motor.

use model_core::plant::board::{BoardPlantOptions, Defects};
use model_core::plant::drivetrain::DrivetrainParameters;
use model_core::plant::drivetrain::friction::FrictionParameters;
use model_core::plant::drivetrain::load::LoadParameters;

use super::bench::{LIMITS, client};
use super::{Findings, Kept, find};
use crate::servo_bus;

/// What a bench with this friction of its gears gives, with relative standard errors below this.
fn commissioned(friction: FrictionParameters, most_error: f64) -> Findings {
    let servo = servo_bus::model("xl330-m288").expect("a model");
    let drivetrain = DrivetrainParameters {
        friction,
        ..servo.drivetrain(LoadParameters::default())
    };
    let plant = BoardPlantOptions {
        drivetrain,
        ..BoardPlantOptions::realistic(3)
    };
    let DrivetrainParameters {
        electrical,
        gear_train,
        ..
    } = drivetrain;
    let mut client = client(&plant, Defects::default());
    // As an owner would: a third off, but for the ratio.
    for (object, value) in [
        ("2011:1", 1.3 * electrical.winding_resistance_ohm),
        ("2011:2", 0.7 * electrical.torque_constant_nm_a),
        ("2011:3", gear_train.gear_ratio),
        ("2011:4", 1.3 * gear_train.inertia_kg_m2()),
        ("2011:8", electrical.winding_inductance_h),
    ] {
        client.write(object, &value.to_string()).expect("in range");
    }
    let kept = Kept::of(&mut client).expect("values");
    let found = find(&mut client, &LIMITS, (&kept, true), |_| {}).expect("a good bench");
    for (found, truth) in [
        (found.resistance_ohm, electrical.winding_resistance_ohm),
        (found.torque_constant_nm_a, electrical.torque_constant_nm_a),
        (found.dynamics.inertia_kg_m2, gear_train.inertia_kg_m2()),
    ] {
        let z = (found.value - truth) / found.standard_error;
        println!("{found:?}, {truth}, {z:.1}");
        assert!(
            z.abs() < 3.0 && found.relative() < most_error,
            "{found:?}, {truth}"
        );
    }
    found
}

/// With Coulomb friction alone. The amplitude of the excitations follows the wanted error.
#[test]
fn gains_of_a_motor_of_another_type_have_the_margins_that_were_promised() {
    let friction = FrictionParameters {
        friction_model: 1.0,
        coulomb_friction_nm: 0.02,
        viscous_friction_nm_s_deg: 0.0,
        ..FrictionParameters::default()
    };
    let found = commissioned(friction, 0.05);
    let tuning = found.tuning.expect("it was tuned");
    assert!(
        tuning.disagreements.is_empty(),
        "{:?}",
        tuning.disagreements
    );
}

/// Fitted to recordings of that servo: friction of the gears grows with the torque, which no
/// parameter of the board describes.
#[test]
fn gains_for_a_motor_that_the_model_does_not_describe_are_not_written() {
    let servo = servo_bus::model("xl330-m288").expect("a model");
    let found = commissioned(servo.drivetrain(LoadParameters::default()).friction, 0.15);
    let doubts = found.doubts().join("\n");
    assert!(doubts.contains("Gains are not written"), "{doubts}");
    assert!(
        found
            .objects()
            .iter()
            .all(|(object, _)| *object != "60FB:1")
    );
}
