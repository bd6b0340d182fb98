//! The torque modes as a master sees them.

use super::*;

/// In cyclic torque mode, between stops at 40 deg, without a timeout of commands.
fn between_stops(mode: u32) -> Bench {
    let mut bench = Bench::new();
    bench.motor = Motor::between_stops(40.0);
    bench.set(0x2040, 1, 0, 4);
    bench.set(0x6060, 0, mode, 1);
    bench.enable();
    bench
}

fn actual(bench: &mut Bench) -> i32 {
    i32::from(bench.get(0x6077, 0) as i16)
}

#[test]
fn a_torque_presses_against_a_stop_and_a_new_one_acts_at_once() {
    let mut bench = between_stops(10);
    for torque in [200_i16, -300] {
        bench.set(0x6071, 0, torque as u16 as u32, 2);
        bench.steps(300);
        assert_eq!(bench.get(0x6074, 0) as i16, torque);
        let actual = actual(&mut bench);
        assert!((actual - i32::from(torque)).abs() <= 15, "{actual}");
        assert!((bench.angle_mdeg().abs() - 40_000).abs() < 500);
        assert_ne!(bench.status() & statusword::MODE_12, 0);
    }
}

#[test]
fn the_offset_is_added_in_the_cyclic_mode_and_a_profile_has_its_slope() {
    let mut bench = between_stops(10);
    bench.set(0x6071, 0, 100, 2);
    bench.set(0x60B2, 0, 50, 2);
    bench.steps(2);
    assert_eq!(bench.get(0x6074, 0), 150);
    assert_eq!((bench.get(0x6071, 0), bench.get(0x60B2, 0)), (100, 50));
    let mut bench = between_stops(4);
    bench.set(0x6087, 0, 100, 4);
    bench.set(0x60B2, 0, 50, 2);
    bench.set(0x6071, 0, 100, 2);
    bench.steps(125);
    // 100 a second for half a second.
    let halfway = bench.get(0x6074, 0);
    assert!((48..=52).contains(&halfway), "{halfway}");
    assert!(!bench.is_reached());
    bench.steps(130);
    assert_eq!(bench.get(0x6074, 0), 100);
    assert!(bench.is_reached());
}

#[test]
fn velocity_and_position_stay_within_6080h_and_607dh() {
    let mut bench = Bench::new();
    bench.set(0x6080, 0, 50_000, 4);
    bench.set(0x2040, 1, 0, 4);
    bench.set(0x6060, 0, 10, 1);
    bench.enable();
    bench.set(0x6071, 0, 400, 2);
    bench.steps(100);
    let velocity = bench.get(0x606C, 0) as i32;
    assert!((40_000..=51_000).contains(&velocity), "{velocity}");
    assert_ne!(bench.status() & statusword::INTERNAL_LIMIT, 0);
    bench.steps(500);
    let place = bench.angle_mdeg();
    assert!((59_000..=60_100).contains(&place), "{place}");
    bench.set(0x6071, 0, -100_i16 as u16 as u32, 2);
    bench.steps(250);
    assert!(bench.angle_mdeg() < 50_000, "{}", bench.angle_mdeg());
}

#[test]
fn a_stop_ends_a_torque_and_polarity_reverses_it() {
    let mut bench = between_stops(10);
    bench.set(0x6071, 0, 200, 2);
    bench.steps(100);
    bench.control(2);
    bench.steps(150);
    assert_eq!(bench.status() & 0x6F, 0x40, "switch on disabled");
    bench.set(0x607E, 0, 0x40, 1);
    bench.enable();
    bench.set(0x6071, 0, 200, 2);
    bench.steps(200);
    assert!(
        (bench.angle_mdeg() + 40_000).abs() < 500,
        "{}",
        bench.angle_mdeg()
    );
    assert!((actual(&mut bench) - 200).abs() <= 15);
    assert_eq!(bench.get(0x6074, 0), 200);
}
