//! A master that falls silent.

use super::*;

/// In a cyclic mode with the master commanding 10 deg, then silence.
fn silent(action: u32) -> Bench {
    let mut bench = Bench::new();
    bench.set(0x2040, 2, action, 1);
    bench.set(0x2040, 3, -20_000_i32 as u32, 4);
    bench.enable();
    bench.cyclic = Some((15, 10_000));
    bench.steps(250);
    assert!((bench.angle_mdeg() - 10_000).abs() <= 176);
    bench.cyclic = None;
    bench.heard.clear();
    bench
}

#[test]
fn by_default_silence_is_a_fault_after_its_time_and_not_before() {
    let mut bench = silent(1);
    bench.steps(24);
    assert!(bench.emergencies().is_empty());
    bench.steps(3);
    assert_eq!(bench.emergencies(), [(0x8130, 15)]);
    bench.until(200, |bench| bench.status() & 0x4F == 0x08);
    bench.control(0x80);
    assert_eq!(bench.status() & 0x6F, 0x40);
    bench.enable();
}

#[test]
fn the_angle_is_held_or_the_failsafe_position_taken() {
    let mut bench = silent(0);
    bench.steps(200);
    assert!((bench.angle_mdeg() - 10_000).abs() <= 176);
    let mut bench = silent(2);
    // 100 ms, then 60 deg/s for 240 ms, behind which the loop stays by at most 60/8 deg.
    bench.steps(25 + 60);
    let angle = bench.angle_mdeg();
    assert!((-4_400..3_500).contains(&angle), "{angle}");
    bench.steps(250);
    assert!((bench.angle_mdeg() + 20_000).abs() <= 176);
    assert!(bench.emergencies().is_empty());
    // The master is there again.
    bench.cyclic = Some((15, 0));
    bench.steps(250);
    assert!(bench.angle_mdeg().abs() <= 176);
}

#[test]
fn a_profile_needs_no_more_than_its_first_command() {
    let mut bench = Bench::enabled(1);
    bench.set(0x607A, 0, 5_000, 4);
    bench.steps(300);
    assert_eq!(bench.status() & 0x6F, 0x27);
}

#[test]
fn a_lost_heartbeat_ends_the_motion_in_every_mode() {
    let mut bench = Bench::enabled(1);
    bench.set(0x1016, 1, 100 << 16 | 40, 4);
    bench.send(0x764, &[5]);
    bench.heard.clear();
    bench.steps(12);
    let seen = bench.emergencies();
    assert!(
        seen.contains(&(0x8130, 100)) && seen.contains(&(0x8130, 15)),
        "{seen:x?}"
    );
    bench.until(200, |bench| bench.status() & 0x4F == 0x08);
}
