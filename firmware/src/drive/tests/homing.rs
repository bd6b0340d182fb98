//! Homing, 6098h, and its origin.

use super::*;

/// Homing by a method from 10 deg between stops at 40 deg; the statusword at the end.
pub(super) fn homed(method: i8, offset_mdeg: i32) -> (Bench, u16) {
    let mut bench = Bench::new();
    bench.motor = Motor::between_stops(40.0);
    bench.set(0x2040, 1, 0, 4);
    bench.enable();
    bench.set(0x607A, 0, 10_000, 4);
    bench.steps(250);
    bench.control(0x06);
    bench.set(0x607C, 0, offset_mdeg as u32, 4);
    bench.set(0x6098, 0, u32::from(method as u8), 1);
    bench.set(0x6060, 0, 6, 1);
    bench.enable();
    bench.set(0x6040, 0, 0x1F, 2);
    assert_eq!(
        bench.status() & 0x3400,
        0,
        "from the answer to the start on"
    );
    bench.until(3_000, |bench| bench.status() & 0x2400 != 0);
    let status = bench.status();
    (bench, status)
}

#[test]
fn each_homing_method_finds_its_place_without_a_fault() {
    // The angle of the encoder that becomes 5 deg: at a stop the shaft rests within its backlash
    // and a count.
    for (method, place, tolerance) in [
        (35, 10_000, 180),
        (37, 10_000, 180),
        (33, 0, 1),
        (-3, 40_000, 180),
        (-4, -40_000, 180),
        (-1, 0, 1),
        (-2, 0, 1),
    ] {
        let (mut bench, status) = homed(method, 5_000);
        assert_eq!(status & 0x3400, 0x1400, "{method}");
        let origin = bench.get(0x2041, 3) as i32;
        assert!(
            (place + origin - 5_000).abs() <= tolerance,
            "{method}: {origin}"
        );
        assert!(bench.emergencies().is_empty(), "{method}");
        bench.steps(100);
        let off = bench.angle_mdeg() - bench.get(0x6062, 0) as i32;
        assert!(off.abs() <= 500, "{method}: at rest, {off}");
    }
}

#[test]
fn without_a_way_to_the_index_homing_fails_and_the_drive_remains_enabled() {
    let (mut bench, status) = homed(34, 0);
    assert_eq!(status & 0x346F, 0x2427, "{status:x}");
    assert_eq!((bench.get(0x2041, 3), bench.emergencies().len()), (0, 0));
}

#[test]
fn positions_limits_and_targets_count_from_the_origin() {
    let (mut bench, _) = homed(35, -50_000);
    assert!((bench.angle_mdeg() + 50_000).abs() <= 180);
    bench.set(0x6060, 0, 8, 1);
    bench.set(0x607A, 0, -100_000_i32 as u32, 4);
    bench.steps(250);
    // The limit of 607Dh; the shaft has turned back by 10 deg.
    assert!((bench.angle_mdeg() + 60_000).abs() <= 180);
    let increments = bench.get(0x6063, 0) as i32;
    assert!(increments.abs() <= 2, "{increments}");
    assert_eq!(bench.get(0x6062, 0) as i32, -60_000);
}

#[test]
fn the_origin_is_stored_with_1010h_and_restored_by_1011h() {
    const SAVE: u32 = u32::from_le_bytes(*b"save");
    const LOAD: u32 = u32::from_le_bytes(*b"load");
    let (mut bench, _) = homed(37, 30_000);
    let origin = bench.get(0x2041, 3) as i32;
    assert!((origin - 20_000).abs() <= 180);
    let shown_after_a_reset = |bench: &mut Bench| {
        bench.control(0);
        bench.send(0, &[0x81, 1]);
        bench.steps(20);
        (bench.get(0x2041, 3) as i32, bench.angle_mdeg())
    };
    bench.set(0x1010, 1, SAVE, 4);
    let (after, angle) = shown_after_a_reset(&mut bench);
    assert_eq!(after, origin);
    assert!((angle - 30_000).abs() <= 500, "{angle}");
    bench.set(0x1011, 1, LOAD, 4);
    let (after, angle) = shown_after_a_reset(&mut bench);
    assert_eq!(after, 0);
    assert!((angle - 10_000).abs() <= 500, "{angle}");
}

#[test]
fn methods_with_switches_are_refused() {
    let mut bench = Bench::new();
    for method in (1..=32).chain([36, 38, -5]) {
        let refused = bench.try_set(0x6098, 0, u32::from(method as i8 as u8), 1);
        assert!(refused.is_err(), "{method}");
    }
    let count = bench.get(0x60E3, 0);
    for sub in 1..=count as u8 {
        let method = bench.get(0x60E3, sub);
        bench.set(0x6098, 0, method & 0xFF, 1);
    }
    assert_eq!(bench.get(0x6502, 0) >> 5 & 1, 1);
}

#[test]
fn a_touch_probe_latches_the_index_by_the_position_of_the_home() {
    let (mut bench, _) = homed(35, 30_000);
    bench.set(0x60B8, 0, 0x35, 2);
    bench.set(0x6060, 0, 8, 1);
    bench.set(0x607A, 0, 10_000, 4);
    bench.steps(250);
    // From 10 deg of the encoder down to -10 deg: the index is at 20 deg, within a count.
    assert_eq!(bench.get(0x60B9, 0), 0x07);
    for sub in [0x60BA, 0x60BB] {
        let latched = bench.get(sub, 0) as i32;
        assert!((latched - 20_000).abs() <= 250, "{latched}");
    }
    let ahead = bench.get(0x60BA, 0) as i32 - bench.get(0x60BB, 0) as i32;
    assert_eq!(ahead, 88, "it enters above and leaves below");
}
