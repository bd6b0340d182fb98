//! A motor that is none of those near the paper's: that of a servo of another maker, with a twelfth
//! of the inertia, a third of the torque constant and friction by the torque of the motor.

use model_core::plant::board::{BoardPlantOptions, Defects};
use model_core::plant::drivetrain::DrivetrainParameters;
use model_core::plant::drivetrain::load::LoadParameters;

use super::bench::{LIMITS, client};
use super::{Kept, find};
use crate::servo_bus;

#[test]
fn a_motor_of_another_type_is_commissioned_by_the_figures_of_its_catalogue() {
    let servo = servo_bus::model("xl330-m288").expect("a model");
    let drivetrain = servo.drivetrain(LoadParameters::default());
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
    for (name, found, truth) in [
        (
            "resistance",
            found.resistance_ohm,
            electrical.winding_resistance_ohm,
        ),
        (
            "torque constant",
            found.torque_constant_nm_a,
            electrical.torque_constant_nm_a,
        ),
        (
            "inertia",
            found.dynamics.inertia_kg_m2,
            gear_train.inertia_kg_m2(),
        ),
    ] {
        let z = (found.value - truth) / found.standard_error;
        println!("{name}: {found:?}, {truth}, {z:.1}");
        assert!(z.abs() < 3.0 && found.relative() < 0.1, "{name}: {found:?}");
    }
    println!("{:?}", found.doubts());
    let tuning = found.tuning.expect("it was tuned");
    println!("{tuning:?}");
    assert!(
        tuning.disagreements.is_empty(),
        "{:?}",
        tuning.disagreements
    );
}
