//! Limits of an axis, at their edges, and demands that continue those of another source.

use canopen::cia402::{Demand, Mode, statusword};

use crate::{Bench, ENABLE};

/// An axis that moves at a velocity in cyclic synchronous velocity mode, without position limits.
fn moving(velocity: i32) -> Bench {
    let mut bench = Bench::enabled(Mode::CyclicVelocity);
    bench.parameters.position_limits = None;
    bench.input.target_velocity = velocity;
    bench.step();
    assert_eq!(bench.step().demand, Demand::Velocity(velocity));
    bench
}

#[test]
fn a_stop_starts_from_the_demand_unless_the_motor_differs_by_more_than_half_of_it() {
    // The quick stop ramp is 24,000 a period.
    for (actual, first) in [(50_000, 100_000), (49_999, 49_999), (150_001, 150_001)] {
        let mut bench = moving(100_000);
        bench.follows = false;
        bench.input.velocity_actual = actual;
        assert_eq!(bench.command(0x02).demand, Demand::Velocity(first - 24_000));
    }
}

#[test]
fn a_velocity_beyond_607fh_is_limited_and_the_limit_reported() {
    for (target, is_limited) in [(500_000, false), (500_001, true), (-500_001, true)] {
        let mut bench = Bench::enabled(Mode::ProfileVelocity);
        bench.parameters.position_limits = None;
        bench.input.target_velocity = target;
        let word = bench.step().statusword;
        assert_eq!(
            word & statusword::INTERNAL_LIMIT != 0,
            is_limited,
            "{target}"
        );
    }
}

#[test]
fn an_axis_at_rest_at_a_position_limit_is_not_limited() {
    let mut bench = Bench::enabled(Mode::ProfileVelocity);
    for position in [60_000, -60_000, 61_000] {
        bench.input.position_actual = position;
        bench.input.target_velocity = 0;
        let word = bench.step().statusword;
        assert_eq!(word & statusword::INTERNAL_LIMIT, 0, "{position}");
    }
}

#[test]
fn a_position_limit_is_approached_at_the_gain_of_the_loop() {
    let mut bench = Bench::enabled(Mode::CyclicVelocity);
    bench.follows = false;
    // 8/s.
    bench.parameters.approach_gain = 8 << 10;
    bench.input.target_velocity = 300_000;
    for (position, velocity) in [(50_000, 80_000), (59_000, 8_000), (60_000, 0), (61_000, 0)] {
        bench.input.position_actual = position;
        assert_eq!(bench.step().demand, Demand::Velocity(velocity));
    }
}

#[test]
fn a_following_error_as_wide_as_its_window_is_not_reported_and_velocity_modes_have_no_error() {
    let mut bench = Bench::enabled(Mode::CyclicPosition);
    bench.follows = false;
    bench.input.target_position = 5_000;
    for _ in 0..100 {
        assert!(!bench.step().following_error_exceeded);
    }
    assert_eq!(bench.step().following_error, 5_000);
    let mut bench = moving(100_000);
    bench.follows = false;
    assert_eq!(bench.step().following_error, 0);
}

#[test]
fn a_position_mode_starts_where_the_motor_is_after_a_velocity_mode() {
    let mut bench = moving(0);
    bench.input.position_actual = 5_000;
    bench.input.mode = Mode::ProfilePosition;
    let demand = Demand::Position {
        position: 5_000,
        velocity: 0,
    };
    assert_eq!(bench.step().demand, demand);
}

#[test]
fn no_target_is_reached_while_an_axis_without_set_point_still_moves() {
    let mut bench = moving(100_000);
    bench.parameters.position_window = u32::MAX;
    bench.parameters.position_window_time_ms = 0;
    bench.input.mode = Mode::ProfilePosition;
    let word = bench.step().statusword;
    assert_eq!(word & statusword::TARGET_REACHED, 0);
    bench.until(|output| output.statusword & statusword::TARGET_REACHED != 0);
    assert_eq!(bench.input.velocity_actual, 0);
}

#[test]
fn the_demand_continues_that_of_another_source() {
    let mut bench = Bench::enabled(Mode::ProfileVelocity);
    bench.axis.reset_demand(0, 70_000);
    // The mode restarts without a target: 12,000 a period.
    assert_eq!(bench.command(ENABLE).demand, Demand::Velocity(58_000));
    let mut bench = Bench::enabled(Mode::ProfilePosition);
    bench.axis.reset_demand(20_000, 0);
    let demand = Demand::Position {
        position: 20_000,
        velocity: 0,
    };
    assert_eq!(bench.command(ENABLE).demand, demand);
}
