//! Tracking with the motor of another servo, whose inertia and friction are fitted to recordings
//! (`host_sim::servo_bus::model`).

use firmware::parameters::{BoardParameters, ObjectValues};
use host_sim::servo_bus::model;
use model_core::plant::board::BoardPlantOptions;
use model_core::plant::drivetrain::DrivetrainParameters;
use model_core::plant::drivetrain::electrical::ElectricalParameters;
use model_core::plant::drivetrain::load::LoadParameters;

use crate::Setup;
use crate::drive::Drive;

/// The servo: of those with a fit the one whose currents are within the range of the board.
pub const NAME: &str = "xl330-m288";

/// A supply is off by so much at most, V.
const SUPPLY_V: f64 = 1.0;

/// Rate by duty at a steady state without friction, deg/s by %, but for a constant factor.
fn rate_by_duty(drivetrain: &DrivetrainParameters) -> f64 {
    let motor = &drivetrain.electrical;
    motor.supply_v / (motor.torque_constant_nm_a * drivetrain.gear_train.gear_ratio)
}

/// The parameters of a board with this motor in 2011h.
fn parameters(drivetrain: &DrivetrainParameters) -> (BoardParameters, ObjectValues) {
    let DrivetrainParameters {
        electrical,
        gear_train,
        friction,
        ..
    } = drivetrain;
    let (mut board, mut values) = (BoardParameters::DEFAULT, ObjectValues::DEFAULT);
    let millivolts = |volts: f64| (volts * 1e3) as i32;
    board.supply.over_voltage_mv = millivolts(electrical.supply_v + SUPPLY_V);
    board.supply.under_voltage_mv = millivolts(electrical.supply_v - SUPPLY_V);
    let model = &mut values.model;
    model.resistance_ohm = electrical.winding_resistance_ohm as f32;
    model.inductance_h = electrical.winding_inductance_h as f32;
    model.torque_constant_nm_a = electrical.torque_constant_nm_a as f32;
    model.gear_ratio = gear_train.gear_ratio as f32;
    model.inertia_kg_m2 = gear_train.inertia_kg_m2() as f32;
    model.viscous_friction_nm_s = friction.viscous_friction_nm_s_deg.to_degrees() as f32;
    model.coulomb_friction_nm =
        (friction.coulomb_friction_nm + gear_train.bearing_friction_nm) as f32;
    (board, values)
}

/// The motor.
pub fn motor() -> ElectricalParameters {
    let servo = model(NAME).expect("a model");
    servo.drivetrain(LoadParameters::default()).electrical
}

/// A drive with this motor. The gains of the rate loop are those of the paper by the rate that a
/// duty makes.
pub fn drive(setup: &Setup, seed: u64, interval_ms: i32) -> Drive {
    let servo = model(NAME).expect("a model");
    let drivetrain = servo.drivetrain(LoadParameters::default());
    let rate_gains = rate_by_duty(&DrivetrainParameters::default()) / rate_by_duty(&drivetrain);
    let plant = BoardPlantOptions {
        drivetrain,
        ..BoardPlantOptions::realistic(seed)
    };
    setup.drive_with(&plant, interval_ms, parameters(&drivetrain), rate_gains)
}
