//! Object 2013h, and 60B1h in cyclic synchronous position mode.

use canopen::Abort;

use super::*;

/// A count of the encoder, mdeg.
const COUNT_MDEG: i32 = 88;

/// The following error 0.8 s after the start of a ramp of 50 deg/s by a target in each control
/// period, mdeg, with these shares of feed-forward and this velocity offset.
fn lag_mdeg(velocity_permille: u32, model_permille: u32, offset_mdeg_s: u32) -> i32 {
    let mut bench = Bench::new();
    bench.set(0x6060, 0, 8, 1);
    bench.set(0x60C2, 1, 4, 1);
    bench.set(0x60B1, 0, offset_mdeg_s, 4);
    bench.set(0x2013, 1, velocity_permille, 2);
    bench.set(0x2013, 2, model_permille, 2);
    bench.enable();
    for period in 0..200 {
        let [a, b, c, d] = i32::to_le_bytes(period * 200);
        bench.send(0x401, &[0x0F, 0, a, b, c, d]);
        bench.step();
    }
    bench.step().motion.following_error_mdeg
}

#[test]
fn the_lag_of_the_position_loop_vanishes_with_the_velocity_feed_forward() {
    // 50 deg/s over the gain of 8.
    let (lag, two_counts) = (6250, 2 * COUNT_MDEG);
    assert!((lag_mdeg(0, 0, 0) - lag).abs() <= two_counts);
    assert!((lag_mdeg(500, 0, 0) - lag / 2).abs() <= two_counts);
    // The demand of a control period is reached at its end at the earliest: 200 mdeg.
    assert!((lag_mdeg(1000, 0, 0)).abs() <= 200 + two_counts);
    assert!((lag_mdeg(1000, 1000, 0)).abs() <= 200 + two_counts);
    assert!((lag_mdeg(0, 0, 50_000)).abs() <= 200 + two_counts);
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
