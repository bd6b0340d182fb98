//! No motion that was not commanded: enabling, changes of mode, targets from before.

use proptest::prelude::*;
use std::vec;

use super::*;

/// One count of the encoder, mdeg, rounded up.
const COUNT_MDEG: i32 = 88;

/// At rest at this angle, by the zero of the encoder; in this mode, with these targets.
fn resting(mode: i8, angle_deg: f32, target_mdeg: i32, velocity_mdeg_s: i32) -> Bench {
    let mut bench = Bench::new();
    bench.set_real(0x2010, 3, -angle_deg);
    bench.set(0x6060, 0, u32::from(mode as u8), 1);
    bench.set(0x607A, 0, target_mdeg as u32, 4);
    bench.set(0x60FF, 0, velocity_mdeg_s as u32, 4);
    bench.set(0x60B1, 0, velocity_mdeg_s as u32, 4);
    bench.set(0x6071, 0, u32::from(target_mdeg as u16), 2);
    bench
}

/// Lets the device run and returns the least and the greatest angle.
fn reach(bench: &mut Bench, periods: u32) -> (i32, i32) {
    let mut range = (i32::MAX, i32::MIN);
    for _ in 0..periods {
        let angle = crate::timing::thousandths(bench.step().telemetry.angle);
        range = (range.0.min(angle), range.1.max(angle));
    }
    range
}

fn mode() -> impl Strategy<Value = i8> {
    prop::sample::select(vec![0_i8, 1, 3, 4, 6, 7, 8, 9, 10])
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: None,
        rng_seed: proptest::test_runner::RngSeed::Fixed(13),
        cases: 200,
        ..ProptestConfig::default()
    })]

    #[test]
    fn enabling_never_moves_the_shaft(
        mode in mode(), angle_deg in -170.0..170.0_f32,
        target_mdeg in prop_oneof![Just(0), -180_000..180_000, any::<i32>()],
        velocity_mdeg_s in prop_oneof![Just(0), any::<i32>()],
        is_rpdo: bool, last in prop_oneof![Just(0x0F_u16), Just(0x1F), Just(0x3F)],
    ) {
        let mut bench = resting(mode, angle_deg, target_mdeg, velocity_mdeg_s);
        bench.steps(2);
        let start = bench.angle_mdeg();
        prop_assert!((start - (angle_deg * 1000.0) as i32).abs() <= COUNT_MDEG);
        for word in [6, 7, last] {
            if is_rpdo {
                let [a, b, c, d] = target_mdeg.to_le_bytes();
                bench.send(0x401, &[word as u8, 0, a, b, c, d]);
                bench.steps(2);
            } else {
                bench.control(word);
            }
        }
        // Less than the timeout of commands.
        let (least, greatest) = reach(&mut bench, 20);
        prop_assert!(start - least <= COUNT_MDEG && greatest - start <= COUNT_MDEG, "{start}: {least} to {greatest}");
        prop_assert_eq!(bench.status() & 0x6F, 0x27);
    }

    #[test]
    fn a_change_of_mode_stops_the_shaft_and_forgets_the_target(
        from in prop::sample::select(vec![3_i8, 9]), to in prop::sample::select(vec![0_i8, 1, 8, 9, 3]),
        angle_deg in -170.0..170.0_f32, target_mdeg in -180_000..180_000, velocity_deg_s in -250..250_i32,
    ) {
        prop_assume!(from != to);
        let mut bench = resting(from, angle_deg, target_mdeg, 0);
        bench.set(0x607D, 1, -2_000_000_i32 as u32, 4);
        bench.set(0x607D, 2, 2_000_000, 4);
        bench.set(0x2040, 1, 0, 4);
        bench.set(0x60B1, 0, 0, 4);
        bench.enable();
        bench.set(0x60FF, 0, (velocity_deg_s * 1000) as u32, 4);
        bench.steps(150);
        let start = bench.angle_mdeg();
        bench.set(0x6060, 0, u32::from(to as u8), 1);
        let (least, greatest) = reach(&mut bench, 150);
        // The ramp of 6084h, and what the loops lag behind it: up to 30 ms, and four encoder
        // counts of it while they settle.
        let speed = f64::from(velocity_deg_s.abs());
        let way_mdeg = 1000.0 * (speed * speed / 2.0 / 3000.0 + 0.04 * speed) + 4.0 * f64::from(COUNT_MDEG);
        let (ahead, back) = if velocity_deg_s < 0 { (start - least, greatest - start) } else { (greatest - start, start - least) };
        prop_assert!(f64::from(ahead) <= way_mdeg, "{ahead} mdeg from {velocity_deg_s} deg/s");
        prop_assert!(back <= 4 * COUNT_MDEG, "{back} mdeg back");
        let (least, greatest) = reach(&mut bench, 50);
        prop_assert!(greatest - least <= 2 * COUNT_MDEG, "at rest");
    }

    #[test]
    fn a_target_is_followed_once_it_is_written_after_enabling(
        mode in prop::sample::select(vec![3_i8, 8, 9]), angle_deg in -50.0..50.0_f32,
    ) {
        let mut bench = resting(mode, angle_deg, 20_000, -30_000);
        bench.set(0x2040, 1, 0, 4);
        bench.set(0x60B1, 0, 0, 4);
        bench.enable();
        bench.steps(20);
        // The values from before, again.
        bench.set(0x607A, 0, 20_000, 4);
        bench.set(0x60FF, 0, -30_000_i32 as u32, 4);
        bench.steps(1200);
        let expected = if mode == 8 { 20_000 } else { -60_000 };
        let angle = bench.angle_mdeg();
        prop_assert!((angle - expected).abs() <= 500, "mode {mode}: {angle}");
    }
}
