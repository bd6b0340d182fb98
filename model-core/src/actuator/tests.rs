//! Actuators that are stepped by their caller.

use super::{Actuator, CommandError, InputLevel, ModelKind, PlantKind, Reading, Settings};
use crate::named::Named;
use proptest::prelude::*;

fn actuator(model: ModelKind, plant: PlantKind) -> Actuator {
    Actuator::try_new(&Settings::new(model, plant)).unwrap()
}

fn any_settings() -> impl Strategy<Value = (ModelKind, PlantKind)> {
    let models = proptest::sample::select(ModelKind::ALL);
    (models, proptest::sample::select(PlantKind::ALL))
}

proptest! {
    #[test]
    fn the_state_at_a_tick_does_not_depend_on_the_length_of_the_steps(
        (model, plant) in any_settings(),
        cuts in proptest::collection::vec(0_u64..90, 1..20),
    ) {
        let mut by_cuts = actuator(model, plant);
        for ticks in &cuts {
            by_cuts.advance(30.0, *ticks).unwrap();
        }
        let mut at_once = actuator(model, plant);
        at_once.advance(30.0, cuts.iter().sum()).unwrap();
        prop_assert_eq!(by_cuts.reading(), at_once.reading());
    }

    #[test]
    fn a_copy_continues_as_the_original(
        (model, plant) in any_settings(), before in 0_u64..2000, after in 0_u64..2000
    ) {
        let mut original = actuator(model, plant);
        original.advance(-40.0, before).unwrap();
        let mut copy = original.clone();
        original.advance(25.0, after).unwrap();
        copy.advance(25.0, after).unwrap();
        prop_assert_eq!(original.reading(), copy.reading());
    }
}

/// Every model with parts that a state must contain: noise, an edge within a period, a stop that is
/// reached, a delay.
fn with_everything((model, plant): (ModelKind, PlantKind), delay_s: f64) -> Settings {
    let mut settings = Settings::new(model, plant);
    settings.setup.delay_s = delay_s;
    settings.encoder.encoder_noise_deg = 0.05;
    settings.pwm = crate::plant::Pwm::Switched;
    settings.first_order.position_limit_deg = 15.0;
    settings
}

proptest! {
    #[test]
    fn a_restored_state_continues_as_a_copy_in_any_actuator_with_the_same_settings(
        kind in any_settings(), parts in proptest::collection::vec((-40.0..40.0, 0_u64..300), 1..8),
        elsewhere in 0_u64..500, inertia in 0.0..0.01,
    ) {
        let settings = with_everything(kind, 0.0);
        let mut original = started(&settings);
        original.set_load_inertia_kg_m2(inertia).unwrap();
        for (command_deg, ticks) in &parts {
            original.advance(*command_deg, *ticks).unwrap();
        }
        let mut copy = original.clone();
        let mut other = started(&settings);
        other.advance(7.0, elsewhere).unwrap();
        let mut saved = other.state();
        original.save_state(&mut saved);
        prop_assert_eq!(&saved, &original.state());
        other.set_state(&saved).unwrap();
        for (command_deg, ticks) in parts {
            copy.advance(command_deg, ticks).unwrap();
            other.advance(command_deg, ticks).unwrap();
            prop_assert_eq!(copy.reading(), other.reading());
            prop_assert_eq!(copy.load(), other.load());
        }
    }

    #[test]
    fn an_advance_from_a_state_is_the_restoring_and_the_advance(
        parts in proptest::collection::vec((-400.0..400.0, 1_u64..300), 1..20), noise in any::<bool>()
    ) {
        let kind = (ModelKind::Board, PlantKind::FirstOrder);
        let settings = if noise { with_everything(kind, 0.0) } else { undelayed(kind.0, kind.1) };
        let (mut at_once, mut by_calls) = (started(&settings), started(&settings));
        let mut saved = at_once.state();
        for (value, ticks) in parts {
            let end = saved.tick() + ticks;
            let level = InputLevel::Position;
            // Whatever else it has done meanwhile.
            at_once.advance(3.0, 17).unwrap();
            let load = at_once.advance_from(&saved, level, value, end);
            by_calls.advance(value, ticks).unwrap();
            prop_assert_eq!(load, Some(by_calls.load()));
            prop_assert_eq!(at_once.reading(), by_calls.reading());
            at_once.save_state(&mut saved);
        }
    }
}

#[test]
fn a_state_of_another_model_is_refused_without_effect() {
    let mut actuator = actuator(ModelKind::Board, PlantKind::FirstOrder);
    actuator.advance(20.0, 777).unwrap();
    let before = actuator.state();
    let other = started(&undelayed(ModelKind::GreyBox, PlantKind::FirstOrder));
    assert_eq!(actuator.set_state(&other.state()), Err(super::OtherModel));
    assert_eq!(actuator.state(), before);
}

#[test]
fn an_advance_from_a_state_does_nothing_where_more_than_the_motor_is_to_do() {
    let drivetrain = undelayed(ModelKind::Board, PlantKind::Drivetrain);
    let mut sampled = undelayed(ModelKind::Board, PlantKind::FirstOrder);
    sampled.setup.host_period_s = 0.02;
    let plain = undelayed(ModelKind::Board, PlantKind::FirstOrder);
    let (angle, rate) = (InputLevel::Position, InputLevel::Rate);
    let cases = [
        (drivetrain, angle, 1.0, 5),
        (sampled, angle, 1.0, 5),
        (plain, rate, 1.0, 5),
        (plain, angle, f64::NAN, 5),
        (plain, angle, 1.0, 0),
    ];
    for (settings, level, value, end) in cases {
        let mut actuator = started(&settings);
        let before = actuator.state();
        assert_eq!(actuator.advance_from(&before, level, value, end), None);
        assert_eq!(actuator.state(), before);
    }
}

#[test]
fn a_command_out_of_range_is_refused_without_effect() {
    let mut actuator = actuator(ModelKind::Board, PlantKind::Drivetrain);
    for command in [f64::NAN, f64::INFINITY, 32_768.0, -1e308] {
        assert_eq!(actuator.advance(command, 1000), Err(CommandError::Value));
        assert_eq!(
            actuator.set_load_torque_nm(command),
            Err(CommandError::Value)
        );
    }
    assert_eq!(
        (actuator.tick(), actuator.reading()),
        (0, Reading::default())
    );
}

#[test]
fn a_torque_on_the_load_slows_the_drivetrain() {
    let angle_after = |torque_nm: f64| {
        let mut actuator = actuator(ModelKind::Board, PlantKind::Drivetrain);
        actuator.set_load_torque_nm(torque_nm).unwrap();
        actuator.advance(60.0, 4000).unwrap();
        actuator.reading().angle_deg
    };
    assert!(angle_after(-0.3) < angle_after(0.0) - 1.0);
}

#[test]
fn a_host_with_a_period_of_20_ms_holds_its_last_sample() {
    let mut settings = Settings::new(ModelKind::BlackBox1, PlantKind::FirstOrder);
    settings.setup.host_period_s = 0.02;
    settings.setup.delay_s = 0.0;
    let mut actuator = Actuator::try_new(&settings).unwrap();
    actuator.advance(0.0, 1).unwrap();
    actuator.advance(10.0, 399).unwrap();
    assert_eq!(actuator.reading().command_deg, 0.0);
    actuator.advance(10.0, 1).unwrap();
    assert_eq!(actuator.reading().command_deg, 10.0);
}

/// The same settings without the delay of the set-up.
fn undelayed(model: ModelKind, plant: PlantKind) -> Settings {
    let mut settings = Settings::new(model, plant);
    settings.setup.delay_s = 0.0;
    settings
}

fn started(settings: &Settings) -> Actuator {
    Actuator::try_new(settings).unwrap()
}

#[test]
fn a_commanded_rate_is_held_by_the_rate_loop_of_every_model_that_has_one() {
    for (model, plant) in [
        (ModelKind::GreyBox, PlantKind::FirstOrder),
        (ModelKind::Board, PlantKind::FirstOrder),
        (ModelKind::Board, PlantKind::Drivetrain),
    ] {
        let mut actuator = started(&undelayed(model, plant));
        for rate_deg_s in [40.0, -60.0] {
            let command = |actuator: &mut Actuator, ticks| {
                actuator
                    .advance_with(InputLevel::Rate, rate_deg_s, ticks)
                    .unwrap();
                actuator.reading().angle_deg
            };
            // The slowest pole is that of the motor, 7.6/s: e^-11 of 100 deg/s is left. The encoder
            // resolves 0.09 deg, of which the estimate makes a ripple that averages out.
            let start_deg = command(&mut actuator, 30_000);
            let mean_deg_s = command(&mut actuator, 10_000) - start_deg;
            assert!(
                (mean_deg_s / 0.5 - rate_deg_s).abs() < 0.5,
                "{model} {mean_deg_s}"
            );
        }
    }
}

#[test]
fn a_duty_moves_the_first_order_motor_by_its_closed_form() {
    let mut actuator = started(&undelayed(ModelKind::Board, PlantKind::FirstOrder));
    for ticks in [1, 19, 80, 400, 3000] {
        actuator
            .advance_with(InputLevel::Duty, -30.0, ticks)
            .unwrap();
        let time_s = crate::time::seconds(actuator.tick());
        let expected = -30.0 * 2.836 * (1.0 - libm::exp(-7.586 * time_s));
        assert!((actuator.reading().rate_deg_s - expected).abs() < 1e-10);
    }
    assert_eq!(actuator.reading().duty_pct, -30.0);
}

#[test]
fn a_voltage_is_the_duty_of_the_mean_voltage_without_its_switching() {
    let mut settings = undelayed(ModelKind::Board, PlantKind::Drivetrain);
    let mut by_duty = started(&settings);
    settings.pwm = crate::plant::Pwm::Switched;
    let mut by_volts = started(&settings);
    for (duty_pct, volts) in [(50.0, 3.0), (-25.0, -1.5), (100.0, 90.0)] {
        by_duty
            .advance_with(InputLevel::Duty, duty_pct, 1234)
            .unwrap();
        by_volts
            .advance_with(InputLevel::Voltage, volts, 1234)
            .unwrap();
        assert_eq!(by_volts.reading(), by_duty.reading());
    }
}

#[test]
fn an_input_that_the_model_does_not_have_is_refused_without_effect() {
    let mut actuator = started(&undelayed(ModelKind::BlackBox1, PlantKind::FirstOrder));
    let refused = Err(CommandError::Level(InputLevel::Duty));
    assert_eq!(actuator.advance_with(InputLevel::Duty, 1.0, 10), refused);
    assert_eq!(
        (actuator.tick(), actuator.level()),
        (0, InputLevel::Position)
    );
}

#[test]
fn no_value_in_transit_is_taken_for_another_quantity() {
    let settings = Settings::new(ModelKind::Board, PlantKind::FirstOrder);
    let mut actuator = started(&settings);
    // 90 deg are in transit for 17.5 ms when the rate is commanded.
    actuator.advance(0.0, 100).unwrap();
    actuator.advance(90.0, 300).unwrap();
    actuator.advance_with(InputLevel::Rate, 0.0, 2000).unwrap();
    assert_eq!(actuator.reading().angle_deg, 0.0);
}

#[test]
fn an_inertia_as_a_signal_is_the_parameter() {
    let mut settings = undelayed(ModelKind::Board, PlantKind::Drivetrain);
    let horn = settings.drivetrain.gear_train.load_inertia_kg_m2;
    let mut by_signal = started(&settings);
    by_signal.set_load_inertia_kg_m2(0.003).unwrap();
    settings.drivetrain.gear_train.load_inertia_kg_m2 = horn + 0.003;
    let mut by_parameter = started(&settings);
    for command_deg in [30.0, -20.0] {
        for actuator in [&mut by_signal, &mut by_parameter] {
            actuator.advance(command_deg, 4321).unwrap();
        }
        assert_eq!(by_signal.reading(), by_parameter.reading());
    }
    assert_eq!(
        by_signal.set_load_inertia_kg_m2(-1e-3),
        Err(CommandError::Value)
    );
}

#[test]
fn an_impulse_changes_the_rate_of_the_load_by_its_inertia() {
    let mut settings = undelayed(ModelKind::Board, PlantKind::Drivetrain);
    settings.drivetrain.gear_train.load_inertia_kg_m2 = 0.004;
    let mut actuator = started(&settings);
    actuator.push_load(0.5, 0.002).unwrap();
    assert!((actuator.load().angle_deg - 0.5).abs() < 1e-12);
    actuator.advance(0.0, 1).unwrap();
    // 0.5 rad/s over one tick, less what the shaft takes back of 0.5 deg: 2 Nm/0.004 kg m^2.
    let rate_deg_s = 0.5_f64.to_degrees() - 500.0_f64.to_degrees() * 50e-6;
    assert!(
        (actuator.load().rate_deg_s - rate_deg_s).abs() < 0.2,
        "{:?}",
        actuator.load()
    );
}

#[test]
fn an_actuator_that_is_placed_holds_its_angle() {
    for model in ModelKind::ALL {
        for plant in PlantKind::ALL {
            let mut actuator = started(&undelayed(*model, *plant));
            actuator.place(40.0).unwrap();
            actuator.advance(40.0, 4000).unwrap();
            // Within an encoder count.
            assert!((actuator.reading().angle_deg - 40.0).abs() < 0.09);
            actuator.place(10.0).unwrap();
            assert!((actuator.reading().angle_deg - 40.0).abs() < 0.09);
        }
    }
}
