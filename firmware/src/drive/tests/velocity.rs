//! Velocity actual value 606Ch, and what the statusword says of it.

use super::*;

/// Whether bit 10, or bit 12, is set, in each of so many control periods.
fn bits(bench: &mut Bench, bit: u16, periods: u32) -> Vec<bool> {
    let steps = (0..periods).map(|_| {
        bench.step();
        bench.actuator.device.drive.outputs().motion.status & bit != 0
    });
    steps.collect()
}

/// The number of changes, and the state at the end.
fn changes(bits: &[bool]) -> (usize, bool) {
    let count = bits.windows(2).filter(|pair| pair[0] != pair[1]).count();
    (count, bits.last() == Some(&true))
}

/// In profile velocity mode, without position limits.
fn turning() -> Bench {
    let mut bench = Bench::new();
    bench.set(0x607D, 1, -2_000_000_i32 as u32, 4);
    bench.set(0x607D, 2, 2_000_000, 4);
    bench.set(0x6060, 0, 3, 1);
    bench.enable();
    bench
}

#[test]
fn a_velocity_is_reached_once_and_stays_so_at_the_default_window() {
    for velocity in [2, 7, 40, 100, 123, 200, -40, -100, -200] {
        let mut bench = turning();
        // From another velocity, so that the target is not reached at the start.
        bench.set(0x60FF, 0, (-velocity * 1000_i32) as u32, 4);
        bench.steps(250);
        bench.set(0x60FF, 0, (velocity * 1000_i32) as u32, 4);
        let reached = bits(&mut bench, statusword::TARGET_REACHED, 1500);
        assert_eq!(changes(&reached), (1, true), "{velocity} deg/s");
        // The loop takes 0.2 s and the tracking as much.
        let first = reached.iter().position(|bit| *bit).expect("reached");
        assert!(first < 125, "{velocity} deg/s: {first}");
    }
}

#[test]
fn standstill_is_reported_once_and_stays_so() {
    let mut bench = turning();
    bench.set(0x60FF, 0, 100_000, 4);
    bench.steps(250);
    bench.set(0x60FF, 0, 0, 4);
    let slow = bits(&mut bench, statusword::MODE_12, 1500);
    assert_eq!(changes(&slow), (1, true));
}

#[test]
fn a_reversal_passes_standstill_and_reaches_its_target() {
    let mut bench = turning();
    bench.set(0x60FF, 0, 200_000, 4);
    bench.steps(250);
    assert_ne!(bench.status() & statusword::TARGET_REACHED, 0);
    bench.set(0x60FF, 0, -200_000_i32 as u32, 4);
    bench.step();
    bench.step();
    let reached = bits(&mut bench, statusword::TARGET_REACHED, 500);
    assert_eq!(changes(&reached), (1, true));
    let velocity = bench.get(0x606C, 0) as i32;
    assert!((velocity + 200_000).abs() < 3_000, "{velocity}");
}
