//! Software position limits 607Dh in the velocity modes.

use super::*;
use crate::timing::thousandths;

/// The farthest angle while a velocity drives the shaft against the limit of 60 deg, mdeg; with
/// these shares of the default gains of the rate loop, and this position gain.
fn farthest(mode: u32, velocity_deg_s: i32, (p, i): (f32, f32), position_gain: f32) -> i32 {
    let mut bench = Bench::new();
    bench.set(0x2040, 1, 0, 4);
    bench.set(0x6060, 0, mode, 1);
    bench.set_real(0x60F9, 1, 1.318 * p);
    bench.set_real(0x60F9, 2, 10.0 * i);
    bench.set_real(0x60FB, 1, position_gain);
    bench.enable();
    bench.set(0x60FF, 0, (velocity_deg_s * 1000) as u32, 4);
    let steps = (0..1500).map(|_| thousandths(bench.step().telemetry.angle));
    let sign = velocity_deg_s.signum();
    steps.map(|angle| angle * sign).max().expect("steps")
}

#[test]
fn a_velocity_stops_the_shaft_at_the_position_limit_with_any_gains() {
    // Shares of Kp and Ki, and how far the shaft may come beyond: two counts of the encoder where
    // the integral gain cancels the motor's pole or more; a degree where it is so much less that
    // the integrator of the rate loop empties after the limit is reached.
    let gains = [
        ((0.3, 0.3), 180),
        ((0.3, 1.0), 180),
        ((1.0, 1.0), 180),
        ((1.0, 2.0), 180),
        ((2.0, 2.0), 180),
        ((3.0, 4.0), 180),
        ((2.0, 1.0), 1_000),
        ((1.0, 0.3), 1_000),
    ];
    for mode in [3, 9] {
        for position_gain in [1.0, 4.0, 8.0, 40.0] {
            for (gain, beyond_mdeg) in gains {
                for velocity_deg_s in [30, -100, 200, -283, 500] {
                    let farthest = farthest(mode, velocity_deg_s, gain, position_gain);
                    assert!(
                        (59_000..=60_000 + beyond_mdeg).contains(&farthest),
                        "mode {mode}, {gain:?} {position_gain}, {velocity_deg_s} deg/s: {farthest}"
                    );
                }
            }
        }
    }
}

#[test]
fn the_position_limit_holds_for_every_deceleration() {
    for mode in [3, 9] {
        for deceleration in [100_000, 1_000_000, 100_000_000] {
            let mut bench = Bench::new();
            bench.set(0x2040, 1, 0, 4);
            bench.set(0x6060, 0, mode, 1);
            bench.set(0x6084, 0, deceleration, 4);
            bench.enable();
            bench.set(0x60FF, 0, 250_000, 4);
            let halts = [0x0F, 0x10F];
            let mut farthest = 0;
            for at in 0..1500 {
                // A halt on the way to the limit does not run through it.
                let word = halts[usize::from(at > 60)];
                if at == 61 {
                    bench.set(0x6040, 0, word, 2);
                }
                farthest = farthest.max(thousandths(bench.step().telemetry.angle));
            }
            assert!(
                farthest <= 60_180,
                "mode {mode}, {deceleration}: {farthest}"
            );
        }
    }
}
