//! Gains and the quantity of the command, which change during a run.

use actuator_fmu::abi::*;
use model_core::actuator::{Actuator, InputLevel, ModelKind, PlantKind, Settings};
use model_core::parameter::Parameters;

use super::host::Host;

fn settings(plant: PlantKind) -> Settings {
    Settings::new(ModelKind::Board, plant)
}

fn set_level(host: &Host, level: i32) -> Status {
    // SAFETY: one reference, one value.
    unsafe { fmi2SetInteger(host.c, &host.reference("input_level"), 1, &level) }
}

#[test]
fn gains_change_while_the_board_runs_as_its_object_dictionary_changes_them() {
    for plant in [PlantKind::FirstOrder, PlantKind::Drivetrain] {
        let mut settings = settings(plant);
        let host = Host::initialized(&settings);
        let mut actuator = Actuator::try_new(&settings).unwrap();
        host.set("command_deg", 60.0);
        let mut angles = Vec::new();
        for step in 0..100 {
            if step == 20 {
                assert_eq!(host.set("position_gain", 2.0), Status::Ok);
                settings.control.set("position_gain", 2.0).unwrap();
                actuator.retune(&settings).unwrap();
            }
            assert_eq!(host.step(f64::from(step) * 0.004, 0.004), Status::Ok);
            actuator.advance(60.0, 80).unwrap();
            let angle_deg = actuator.reading().angle_deg;
            assert_eq!(host.get("angle_deg").to_bits(), angle_deg.to_bits());
            angles.push(angle_deg);
        }
        // The untuned board is faster.
        let mut fast = Actuator::try_new(&self::settings(plant)).unwrap();
        fast.advance(60.0, 8000).unwrap();
        assert!(fast.reading().angle_deg > angles[99] + 1.0);
    }
}

#[test]
fn gains_of_the_grey_box_change_without_a_jump_and_its_motor_is_fixed() {
    let mut settings = Settings::new(ModelKind::GreyBox, PlantKind::FirstOrder);
    let host = Host::initialized(&settings);
    let mut actuator = Actuator::try_new(&settings).unwrap();
    host.set("command_deg", 5.0);
    for step in 0..100 {
        if step == 20 {
            let duty_pct = host.get("duty_pct");
            for (name, value) in [("position_gain", 3.0), ("proportional_gain", 0.7)] {
                assert_eq!(host.set(name, value), Status::Ok);
                settings.set(name, value).unwrap();
                actuator.retune(&settings).unwrap();
            }
            assert!((host.get("duty_pct") - duty_pct).abs() < 1e-12);
        }
        assert_eq!(host.step(f64::from(step) * 0.004, 0.004), Status::Ok);
        actuator.advance(5.0, 80).unwrap();
        let angle_deg = actuator.reading().angle_deg;
        assert_eq!(host.get("angle_deg").to_bits(), angle_deg.to_bits());
    }
    assert_eq!(host.set("proportional_gain", -1.0), Status::Error);
    assert_eq!(host.set("motor_gain_up", 2.0), Status::Error);
    assert!(host.last_message().contains("motor_gain_up is fixed"));
    assert_eq!(host.get("proportional_gain"), 0.7);
}

#[test]
fn a_gain_out_of_range_and_a_parameter_that_is_fixed_change_nothing() {
    let host = Host::initialized(&settings(PlantKind::FirstOrder));
    assert_eq!(host.set("position_gain", -1.0), Status::Error);
    assert!(host.last_message().contains("position_gain"));
    assert_eq!(host.set("motor_gain_up", 2.0), Status::Error);
    assert!(host.last_message().contains("motor_gain_up is fixed"));
    assert_eq!(host.set("encoder_zero_deg", 2.0), Status::Error);
    assert_eq!(host.get("position_gain"), 8.0);
}

#[test]
fn the_command_is_a_rate_a_duty_or_a_voltage_where_the_level_says_so() {
    let bench = settings(PlantKind::Drivetrain);
    let inputs = [
        ("command_rate_deg_s", InputLevel::Rate, 50.0),
        ("command_duty_pct", InputLevel::Duty, 30.0),
        ("command_v", InputLevel::Voltage, 2.0),
    ];
    for (name, level, value) in inputs {
        let host = Host::initialized(&bench);
        let mut actuator = Actuator::try_new(&bench).unwrap();
        assert_eq!(set_level(&host, level as i32), Status::Ok);
        assert_eq!(host.set(name, value), Status::Ok);
        assert_eq!(host.step(0.0, 0.3), Status::Ok, "{}", host.last_message());
        actuator.advance_with(level, value, 6000).unwrap();
        let angle_deg = actuator.reading().angle_deg;
        assert_eq!(
            host.get("angle_deg").to_bits(),
            angle_deg.to_bits(),
            "{name}"
        );
        assert!(angle_deg > 1.0, "{name}: {angle_deg}");
    }
}

#[test]
fn a_level_that_the_model_lacks_is_refused() {
    let host = Host::initialized(&settings(PlantKind::FirstOrder));
    for level in [3, 4, -1] {
        assert_eq!(set_level(&host, level), Status::Error);
        assert!(host.last_message().contains("input_level is"));
    }
}

#[test]
fn gains_and_level_are_part_of_a_saved_state() {
    let host = Host::initialized(&settings(PlantKind::FirstOrder));
    host.set("position_gain", 3.0);
    set_level(&host, 2);
    host.set("command_duty_pct", 40.0);
    host.step(0.0, 0.1);
    let bytes = host.bytes(host.keep());
    host.step(0.1, 0.1);
    let expected = host.outputs();
    let other = Host::initialized(&settings(PlantKind::FirstOrder));
    let state = other.keep_bytes(&bytes).unwrap();
    // SAFETY: a state of this instance.
    assert_eq!(unsafe { fmi2SetFMUstate(other.c, state) }, Status::Ok);
    assert_eq!(other.get("position_gain"), 3.0);
    assert_eq!(other.step(0.1, 0.1), Status::Ok);
    assert_eq!(other.outputs(), expected);
}
