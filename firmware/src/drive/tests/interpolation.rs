//! Interpolated position mode: a master of 50 Hz makes no staircase.

use super::*;

/// Position demands while a master writes a point of a ramp of 25 deg/s in these control periods.
fn demands(written: impl Fn(u32) -> bool) -> Vec<i32> {
    let mut bench = Bench::enabled(7);
    bench.control(0x1F);
    let mut point = 0;
    let mut demands = Vec::new();
    for period in 0..300 {
        if written(period) {
            point += 500;
            let [a, b, c, d] = i32::to_le_bytes(point);
            let answer = bench.sdo([0x23, 0xC1, 0x60, 1, a, b, c, d]);
            assert_eq!(answer[0], 0x60);
        }
        let outputs = bench.step();
        demands.push(outputs.motion.position_mdeg);
    }
    demands
}

#[test]
fn points_every_20_ms_with_jitter_are_one_steady_motion() {
    // Up to two periods early or late.
    let jitter = [0, 2, -2, 1, -1, 2, 0, -2];
    let written = |period: u32| {
        let near = (period + 2) / 5;
        let shift = jitter[near as usize % 8];
        period as i32 == 5 * near as i32 + shift
    };
    let demands = demands(written);
    // From the first second point on each period has a fifth of 0.5 deg.
    let steps: Vec<_> = demands.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let steady: Vec<_> = steps.iter().skip(20).collect();
    assert!(steady.iter().all(|step| **step == 100), "{steady:?}");
}

#[test]
fn points_wait_for_bit_4_and_a_full_buffer_delays_the_answer() {
    let mut bench = Bench::new();
    bench.set(0x2040, 1, 0, 4);
    bench.set(0x6060, 0, 7, 1);
    bench.enable();
    assert_eq!(bench.status() & 0x1000, 0);
    for point in 1..=16 {
        bench.set(0x60C1, 1, point * 200, 4);
    }
    assert_eq!((bench.get(0x60C4, 4), bench.angle_mdeg()), (16, 0));
    // An RPDO would be refused; the answer to an SDO waits until there is room.
    let [a, b, c, d] = 3_400_u32.to_le_bytes();
    bench.received.clear();
    bench.send(0x601, &[0x23, 0xC1, 0x60, 1, a, b, c, d]);
    bench.steps(20);
    let is_answer = |frame: &CanFrame| frame.raw_id().0 == 0x581;
    assert!(!bench.received.iter().any(is_answer));
    bench.send(0x201, &[0x1F, 0]);
    bench.steps(10);
    assert!(bench.received.iter().any(is_answer));
    assert_eq!(bench.status() & 0x1000, 0x1000);
    bench.steps(150);
    assert_eq!((bench.get(0x60C4, 4), bench.get(0x6062, 0)), (0, 3_400));
}

#[test]
fn a_change_of_mode_and_60c4h_clear_the_buffer() {
    let mut bench = Bench::enabled(7);
    bench.set(0x60C1, 1, 1_000, 4);
    bench.set(0x60C4, 6, 1, 1);
    assert_eq!(bench.get(0x60C4, 4), 1);
    bench.set(0x60C4, 6, 0, 1);
    assert_eq!(bench.get(0x60C4, 4), 0);
    bench.set(0x60C1, 1, 1_000, 4);
    // An RPDO with mode and point writes the mode with each point.
    bench.set(0x6060, 0, 7, 1);
    assert_eq!(bench.get(0x60C4, 4), 1);
    bench.set(0x6060, 0, 8, 1);
    assert_eq!(bench.get(0x60C4, 4), 0);
}

#[test]
fn points_of_a_motion_that_has_ended_move_nothing_in_the_next_one() {
    let mut bench = Bench::enabled(7);
    bench.control(0x1F);
    for point in 1..=16 {
        bench.set(0x60C1, 1, point * 200, 4);
    }
    bench.control(0x06);
    bench.steps(50);
    assert_eq!(bench.get(0x60C4, 4), 0);
    bench.control(0x1F);
    let place = bench.get(0x6062, 0);
    bench.steps(50);
    assert_eq!(bench.get(0x6062, 0), place);
}

#[test]
fn without_points_the_master_is_lost_after_the_timeout() {
    let mut bench = Bench::enabled(7);
    bench.control(0x1F);
    bench.steps(100);
    assert_eq!(bench.status() & 0x6F, 0x27, "before the first point");
    bench.set(0x60C1, 1, 1_000, 4);
    bench.received.clear();
    bench.steps(40);
    assert_eq!(bench.emergencies(), [(0x8130, 0x8F)]);
}
