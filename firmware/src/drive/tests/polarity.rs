//! Polarity 607Eh, offsets and limits of targets, 6007h, and bits of status and inputs.

use super::*;
use crate::timing::thousandths;

fn encoder_mdeg(bench: &Bench) -> i32 {
    thousandths(bench.actuator.device.drive.outputs().telemetry.angle)
}

#[test]
fn polarity_reverses_every_position_and_velocity() {
    let mut bench = Bench::new();
    bench.set(0x607E, 0, 0xC0, 1);
    bench.set(0x607D, 1, -20_000_i32 as u32, 4);
    bench.set(0x2040, 1, 0, 4);
    bench.enable();
    bench.set(0x607A, 0, 30_000, 4);
    bench.steps(8);
    // On the way: velocities, following error.
    for object in [0x606C, 0x60F4, 0x60FA, 0x6064] {
        assert!(bench.get(object, 0) as i32 > 0, "{object:x}");
    }
    bench.steps(300);
    assert_eq!(
        (bench.get(0x607A, 0), bench.get(0x6062, 0)),
        (30_000, 30_000)
    );
    assert!((bench.angle_mdeg() - 30_000).abs() <= 176);
    assert!((encoder_mdeg(&bench) + 30_000).abs() <= 176);
    bench.set(0x607A, 0, -50_000_i32 as u32, 4);
    bench.steps(300);
    assert!((bench.angle_mdeg() + 20_000).abs() <= 176, "607Dh");
    assert!(bench.try_set(0x607E, 0, 0, 1).is_err(), "while enabled");
    bench.set(0x6060, 0, 3, 1);
    bench.set(0x60FF, 0, 20_000, 4);
    bench.steps(100);
    assert_eq!(
        (bench.get(0x60FF, 0), bench.get(0x606B, 0)),
        (20_000, 20_000)
    );
    assert!((bench.get(0x606C, 0) as i32 - 20_000).abs() <= 1_500);
    assert!(
        bench
            .outputs
            .is_some_and(|outputs| thousandths(outputs.telemetry.rate) < -10_000)
    );
}

#[test]
fn with_reversed_positions_homing_searches_upward_where_the_user_counts_upward() {
    let mut bench = Bench::new();
    bench.motor = Motor::between_stops(40.0);
    bench.set(0x607E, 0, 0x80, 1);
    bench.set(0x607C, 0, 7_000, 4);
    bench.set(0x6098, 0, u32::from(-3_i8 as u8), 1);
    bench.set(0x6060, 0, 6, 1);
    bench.enable();
    bench.set(0x6040, 0, 0x1F, 2);
    bench.until(3_000, |bench| bench.status() & 0x2400 != 0);
    assert!((encoder_mdeg(&bench) + 40_000).abs() <= 180);
    bench.steps(50);
    assert!((bench.angle_mdeg() - 7_000).abs() <= 500);
}

#[test]
fn the_position_offset_is_added_in_the_cyclic_mode_only() {
    let mut bench = Bench::new();
    bench.set(0x2040, 1, 0, 4);
    bench.enable();
    bench.set(0x607A, 0, 10_000, 4);
    bench.set(0x60B0, 0, 5_000, 4);
    bench.steps(250);
    assert!((bench.angle_mdeg() - 15_000).abs() <= 176);
    bench.set(0x6060, 0, 1, 1);
    bench.control(0x1F);
    bench.until(500, Bench::is_reached);
    assert!((bench.angle_mdeg() - 10_000).abs() <= 500);
}

#[test]
fn profiles_obey_60c5h_and_60c6h() {
    let periods = |limit: Option<u32>| {
        let mut bench = Bench::new();
        if let Some(limit) = limit {
            bench.set(0x60C5, 0, limit, 4);
            bench.set(0x60C6, 0, limit, 4);
        }
        bench.set(0x6060, 0, 1, 1);
        bench.enable();
        bench.set(0x607A, 0, 20_000, 4);
        bench.control(0x1F);
        bench.until(1_000, |bench| bench.get(0x6062, 0) == 20_000)
    };
    // 2 sqrt(20 deg / 3000 deg/s^2) and 2 sqrt(20 deg / 100 deg/s^2), in periods of 4 ms.
    let (fast, slow) = (periods(None), periods(Some(100_000)));
    assert!((36..=42).contains(&fast), "{fast}");
    assert!((219..=226).contains(&slow), "{slow}");
}

#[test]
fn a_jerk_limited_profile_takes_longer_by_its_mean() {
    let periods = |kind: u32| {
        let mut bench = Bench::new();
        bench.set(0x6086, 0, kind, 2);
        bench.set(0x6060, 0, 1, 1);
        bench.enable();
        bench.set(0x607A, 0, 20_000, 4);
        bench.control(0x1F);
        bench.until(1_000, |bench| bench.get(0x6062, 0) == 20_000)
    };
    // 3000 deg/s^2 by 60,000 deg/s^3: 50 ms.
    let longer = periods(3) - periods(0);
    assert!((11..=13).contains(&longer), "{longer}");
}

#[test]
fn each_code_of_6007h_is_an_action_of_the_failsafe() {
    // State bits of the statusword after a second without commands; 605Ah = 2.
    for (code, action, state) in [
        (-2, 2, 0x27),
        (-1, 0, 0x27),
        (0, 3, 0x27),
        (1, 1, 0x08),
        (2, 4, 0x40),
        (3, 5, 0x40),
    ] {
        let mut bench = Bench::new();
        bench.set(0x6007, 0, u32::from(code as u16), 2);
        assert_eq!(bench.get(0x2040, 2), action);
        assert_eq!(bench.get(0x6007, 0) as i32 as i16, code as i16);
        bench.enable();
        bench.cyclic = Some((15, 10_000));
        bench.steps(100);
        bench.cyclic = None;
        bench.steps(250);
        assert_eq!(bench.status() & 0x4F, state & 0x4F, "{code}");
    }
    let mut bench = Bench::new();
    assert!(bench.try_set(0x6007, 0, 4, 2).is_err());
    // A quick stop that ends in its state lasts until the master is back.
    bench.set(0x6007, 0, 3, 2);
    bench.set(0x605A, 0, 6, 2);
    bench.enable();
    bench.cyclic = Some((15, 10_000));
    bench.steps(100);
    bench.cyclic = None;
    bench.steps(250);
    assert_eq!(bench.status() & 0x6F, 0x07);
    bench.cyclic = Some((15, 20_000));
    bench.steps(3);
    assert_eq!(bench.status() & 0x6F, 0x27);
}

#[test]
fn the_remote_bit_and_the_input_follow_the_servo_pulse() {
    let mut bench = Bench::new();
    assert_eq!((bench.status() >> 9 & 1, bench.get(0x60FD, 0)), (1, 0));
    bench.set(0x2000, 0, 1, 1);
    bench.step_with(|samples| samples.servo_pulse_us = Some(1500));
    bench.step();
    assert_eq!(
        (bench.status() >> 9 & 1, bench.get(0x60FD, 0)),
        (0, 1 << 16)
    );
    bench.set(0x2000, 0, 0, 1);
    bench.steps(2);
    assert_eq!(bench.status() >> 9 & 1, 1);
}
