//! Torques on the plant whose current pulses.

use model_core::{control::units::angle, plant::board::BoardPlantOptions};

use super::{winding::Loop, *};

/// Rated torque, N m: 500 mA times 0.00362 N m/A times 320.
const RATED_NM: f64 = 0.579;

const FREE: (i32, i32) = (-1_000_000, 1_000_000);

fn torque(board: &mut Loop, permille: i16, rates_mdeg_s: (i32, i32), periods: u32) -> Outputs {
    let mut last = None;
    for _ in 0..periods {
        let torque = TorqueSetpoint {
            permille,
            rates_mdeg_s,
        };
        let _ = board.application.request(Request::Torque(torque));
        last = Some(board.step());
    }
    last.expect("stepped")
}

#[test]
fn the_torque_of_a_jammed_shaft_is_that_of_the_setpoint() {
    for permille in [-1000, -500, -200, 100, 400, 1000] {
        let mut board = Loop::enabled();
        board.plant.plant.defects.is_jammed = true;
        let outputs = torque(&mut board, permille, FREE, 100);
        assert_eq!((outputs.state, outputs.fault), (BoardState::Enabled, None));
        let (expected_ma, mean_ma) = (i32::from(permille) / 2, outputs.telemetry.current_ma);
        // The winding has warmed by 2 % of its resistance at the most, and 5 mA are two codes.
        let tolerance_ma = 5 + expected_ma.abs() / 50;
        assert!(
            (mean_ma - expected_ma).abs() <= tolerance_ma,
            "{permille}: {mean_ma} mA"
        );
    }
}

#[test]
fn a_load_below_the_torque_is_lifted_and_one_above_it_lowers() {
    for (load_nm, direction) in [(0.24, 1.0), (0.36, -1.0)] {
        let mut board = Loop::enabled();
        // 0.3 N m, and friction on either side.
        board.plant.plant.defects.torque_nm = -load_nm;
        let permille = (0.3 / RATED_NM * 1000.0) as i16;
        let outputs = torque(&mut board, permille, FREE, 50);
        let rate = outputs.telemetry.rate.to_f64() * direction;
        // 0.03 N m beyond the friction, on 0.023 kg m^2 for 0.2 s: 15 deg/s.
        assert!(rate > 5.0, "{load_nm} N m: {rate} deg/s");
    }
}

#[test]
fn no_torque_leaves_the_shaft_free() {
    let mut board = Loop::enabled();
    board.plant.plant.defects.torque_nm = 0.2;
    let outputs = torque(&mut board, 0, FREE, 75);
    assert!(
        outputs.telemetry.current_ma.abs() <= 15,
        "{}",
        outputs.telemetry.current_ma
    );
    // 0.17 N m on 0.023 kg m^2 for 0.3 s are 127 deg/s; a shorted motor would turn with 60 deg/s.
    assert!(
        outputs.telemetry.rate > rate(115.0),
        "{}",
        outputs.telemetry.rate
    );
}

#[test]
fn a_torque_accelerates_up_to_the_greatest_rate_and_brakes_a_load_beyond_it() {
    let mut board = Loop::enabled();
    let outputs = torque(&mut board, 500, (-100_000, 60_000), 150);
    let free = outputs.telemetry.velocity_mdeg_s;
    // Below it by what the friction needs, 0.03 N m over 1.158 N m/A times 7.7 ohm over 5, 2 deg/s.
    assert!(
        outputs.telemetry.limits.rate && (56_500..60_000).contains(&free),
        "{free}"
    );
    for direction in [1.0, -1.0] {
        board.plant.plant.defects.torque_nm = 0.3 * direction;
        let permille = if direction > 0.0 { 500 } else { 0 };
        let outputs = torque(&mut board, permille, (-60_000, 60_000), 150);
        // The brake lowers 0.3 N m at 18 deg/s.
        let loaded = outputs.telemetry.rate.to_f64() * direction;
        assert!((60.0..85.0).contains(&loaded), "{loaded}");
    }
}

#[test]
fn a_position_mode_takes_over_without_a_fault_and_holds_the_shaft() {
    let mut board = Loop::with(&BoardPlantOptions::realistic(3));
    torque(&mut board, 300, (-40_000, 40_000), 100);
    let place = board.application.outputs().telemetry.angle;
    let outputs = board.follow(place, 250);
    assert_eq!((outputs.state, outputs.fault), (BoardState::Enabled, None));
    assert!((outputs.telemetry.angle - place).abs() < angle(0.5));
}

#[test]
fn what_follows_a_torque_starts_without_the_duty_that_accelerated_the_shaft() {
    let mut board = Loop::enabled();
    while board.application.outputs().telemetry.rate < rate(50.0) {
        torque(&mut board, 1500, FREE, 1);
    }
    let from = board.application.outputs().telemetry.angle;
    let mut farthest = from;
    for _ in 0..100 {
        let _ = board
            .application
            .request(Request::Command(rate(0.0).into()));
        farthest = farthest.max(board.step().telemetry.angle);
    }
    // With the duty of 0.75 A at 7.7 ohm in the integrator it were 10 deg.
    assert!(farthest - from < angle(3.0), "{}", farthest - from);
}
