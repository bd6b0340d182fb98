//! Object 2013h.

use canopen::Abort;

use super::*;

/// A count of the encoder, mdeg.
const COUNT_MDEG: i32 = 88;

fn outputs(bench: &Bench) -> &Outputs {
    bench.actuator.device.drive.outputs()
}

/// Enables the drive and turns it with 50 deg/s by a target in each control period; returns the
/// following error after 0.8 s, mdeg.
fn ramp(bench: &mut Bench) -> i32 {
    bench.enable();
    for period in 0..200 {
        let [a, b, c, d] = i32::to_le_bytes(period * 200);
        bench.send(0x401, &[0x0F, 0, a, b, c, d]);
        bench.step();
    }
    bench.step().motion.following_error_mdeg
}

/// The following error 0.8 s after the start of a ramp of 50 deg/s by a target in each control
/// period, mdeg, with these shares of feed-forward.
fn lag_mdeg(velocity_permille: u32, model_permille: u32) -> i32 {
    let mut bench = Bench::new();
    bench.set(0x6060, 0, 8, 1);
    bench.set(0x60C2, 1, 4, 1);
    bench.set(0x2013, 1, velocity_permille, 2);
    bench.set(0x2013, 2, model_permille, 2);
    ramp(&mut bench)
}

#[test]
fn the_lag_of_the_position_loop_vanishes_with_the_velocity_feed_forward() {
    // 50 deg/s over the gain of 8.
    let (lag, two_counts) = (6250, 2 * COUNT_MDEG);
    assert!((lag_mdeg(0, 0) - lag).abs() <= two_counts);
    assert!((lag_mdeg(500, 0) - lag / 2).abs() <= two_counts);
    // The demand of a control period is reached at its end at the earliest: 200 mdeg.
    assert!((lag_mdeg(1000, 0)).abs() <= 200 + two_counts);
    assert!((lag_mdeg(1000, 1000)).abs() <= 200 + two_counts);
}

#[test]
fn the_lag_vanishes_with_60b1h_of_the_same_velocity_until_a_halt_ends_it() {
    let mut bench = Bench::new();
    bench.set(0x6060, 0, 8, 1);
    bench.set(0x60C2, 1, 4, 1);
    bench.set(0x60B1, 0, 50_000, 4);
    let error = ramp(&mut bench);
    assert!(error.abs() <= 200 + 2 * COUNT_MDEG, "{error}");
    bench.control(0x10F);
    bench.steps(250);
    assert!(
        outputs(&bench).motion.following_error_mdeg.abs() <= COUNT_MDEG,
        "at rest"
    );
}

#[test]
fn the_torque_60b2h_is_added_at_once_in_the_cyclic_modes_of_position_and_velocity() {
    // Also of a shaft that rests within a dead band.
    for (mode, expected, dead_band) in [
        (1, 0.0, 0),
        (3, 0.0, 0),
        (8, 1.0, 0),
        (8, 1.0, 132),
        (9, 1.0, 0),
    ] {
        let mut bench = Bench::new();
        bench.set(0x2013, 3, dead_band, 2);
        bench.set(0x2040, 1, 0, 4);
        bench.set(0x6060, 0, mode, 1);
        bench.enable();
        let target = if mode == 8 { 0x607A } else { 0x60FF };
        bench.set(target, 0, 0, 4);
        bench.steps(250);
        let supply_mv = f64::from(outputs(&bench).telemetry.supply_mv);
        let ohm = f32::from_bits(bench.get(0x2011, 1));
        let rated_ma = f64::from(bench.get(0x6075, 0));
        let before = outputs(&bench).telemetry.duty.to_f64();
        assert!(dead_band == 0 || before == 0.0, "{before}");
        bench.set(0x60B2, 0, 100, 2);
        let change = bench.step().telemetry.duty.to_f64() - before;
        let of_torque = 100.0 * 0.1 * rated_ma * f64::from(ohm) / supply_mv;
        assert!(
            (change - expected * of_torque).abs() < 0.01,
            "{mode}: {change}, {of_torque}"
        );
        // A halt does not end it: a load is held on.
        let before = outputs(&bench).telemetry.duty.to_f64();
        bench.control(0x10F);
        let duty = bench.step().telemetry.duty.to_f64();
        assert!((duty - before).abs() < 1.0, "{mode}: {before}, {duty}");
    }
}

#[test]
fn feed_forward_does_not_change_while_the_shaft_is_driven() {
    let mut bench = Bench::enabled(8);
    for sub in 1..=3 {
        let refused = Err(Abort::DeviceState.code());
        assert_eq!(bench.try_set(0x2013, sub, 100, 2), refused, "{sub}");
    }
    bench.control(6);
    for sub in 1..=3 {
        assert_eq!(bench.try_set(0x2013, sub, 100, 2), Ok(()), "{sub}");
    }
}

#[test]
fn a_shaft_that_is_enabled_after_a_motion_does_not_move() {
    let mut bench = Bench::new();
    bench.set(0x2040, 1, 0, 4);
    bench.set(0x6060, 0, 3, 1);
    bench.set(0x2013, 1, 1000, 2);
    bench.set(0x2013, 2, 1000, 2);
    bench.enable();
    bench.set(0x60FF, 0, 90_000, 4);
    bench.steps(100);
    // Power ends in the motion.
    bench.control(0);
    bench.steps(500);
    let start = bench.angle_mdeg();
    bench.set(0x60FF, 0, 0, 4);
    bench.enable();
    for _ in 0..50 {
        let outputs = bench.step();
        assert!(
            outputs.telemetry.duty.to_f64().abs() < 15.0,
            "noise of a count"
        );
        assert!((bench.angle_mdeg() - start).abs() <= 2 * COUNT_MDEG);
    }
}

#[test]
fn a_motor_that_is_fed_forward_does_not_change_while_it_is_driven() {
    let refused = Err(Abort::DeviceState.code());
    for (permille, expected) in [(0, Ok(())), (1000, refused)] {
        let mut bench = Bench::new();
        bench.set(0x2013, 2, permille, 2);
        bench.enable();
        let gears = 300.0_f32.to_bits();
        assert_eq!(bench.try_set(0x2011, 3, gears, 4), expected, "{permille}");
        assert_eq!(bench.try_set(0x60C2, 1, 40, 1), expected, "{permille}");
        bench.control(6);
        assert_eq!(bench.try_set(0x2011, 3, gears, 4), Ok(()));
    }
}

/// The bench's encoder shows the angle of the shaft: what is declared as its error moves the shaft.
#[test]
fn the_position_is_that_of_the_encoder_less_its_declared_error() {
    // 1.4 deg at a quarter turn, and twice a turn -0.5 deg of cosine, which is 0 at the zero and 1
    // deg there.
    for (sub, mdeg, error_deg) in [(2, 1400, 1.4), (3, -500, 1.0), (1, 1000, -1.0)] {
        let mut bench = Bench::new();
        bench.set(0x607D, 2, 100_000, 4);
        bench.set(0x2014, sub, mdeg as u32, 2);
        bench.set(0x6060, 0, 1, 1);
        bench.enable();
        assert!(bench.try_set(0x2014, sub, 0, 2).is_err(), "locked");
        bench.set(0x607A, 0, 90_000, 4);
        bench.control(0x1F);
        bench.steps(1000);
        assert!(bench.is_reached());
        let mdeg = bench.angle_mdeg();
        assert!((mdeg - 90_000).abs() <= 2 * COUNT_MDEG, "{mdeg}");
        let shaft_deg = bench.motor.angle_deg();
        assert!((shaft_deg - 90.0 - error_deg).abs() < 0.2, "{shaft_deg}");
    }
}
