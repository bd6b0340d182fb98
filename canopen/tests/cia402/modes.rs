use canopen::cia402::{Demand, Mode, Offsets, Output, controlword, statusword};

use crate::{Bench, ENABLE, NEW, model::MODES};

const ACKNOWLEDGE: u16 = statusword::MODE_12;

fn has(word: u16, bit: u16) -> bool {
    word & bit != 0
}

#[test]
fn a_set_point_is_acknowledged_and_reached() {
    let mut bench = Bench::enabled(Mode::ProfilePosition);
    bench.input.target_position = 30_000;
    let still = bench.step();
    assert!(
        !has(still.statusword, ACKNOWLEDGE),
        "607Ah alone moves nothing"
    );
    assert!(has(bench.command(NEW).statusword, ACKNOWLEDGE));
    assert!(!has(bench.command(ENABLE).statusword, ACKNOWLEDGE));
    let periods = bench.until(|output| has(output.statusword, statusword::TARGET_REACHED));
    assert_eq!(bench.input.position_actual, 30_000);
    // 0.2 s of motion and 20 ms in the window, minus the two periods of the command.
    assert!((50..=56).contains(&periods), "{periods}");
}

#[test]
fn one_set_point_is_buffered_and_a_third_is_not_acknowledged() {
    let mut bench = Bench::enabled(Mode::ProfilePosition);
    let mut targets = [10_000, 20_000].into_iter();
    for _ in 0..2 {
        bench.input.target_position = targets.next().expect("two");
        assert!(has(bench.command(NEW).statusword, ACKNOWLEDGE));
        bench.command(ENABLE);
    }
    assert!(
        has(bench.step().statusword, ACKNOWLEDGE),
        "the buffer is full"
    );
    bench.input.target_position = 30_000;
    bench.command(NEW);
    bench.command(ENABLE);
    bench.until(|output| !has(output.statusword, ACKNOWLEDGE));
    // The first target is reached; one period of 12 deg/s toward the second is 48 mdeg.
    assert_eq!(bench.input.position_actual, 10_048);
    bench.until(|output| has(output.statusword, statusword::TARGET_REACHED));
    assert_eq!(
        bench.input.position_actual, 20_000,
        "the third is discarded"
    );
}

#[test]
fn a_buffered_set_point_waits_for_the_motor_and_for_a_second_at_most() {
    // Within the window, 20 ms; outside, a second more. The next is written with the first, or when
    // the demand has arrived.
    for (place, wait, is_late) in [
        (9_500, 6, false),
        (9_499, 257, false),
        (9_500, 6, true),
        (9_499, 257, true),
    ] {
        let mut bench = Bench::enabled(Mode::ProfilePosition);
        bench.follows = false;
        let give = |bench: &mut Bench, target| {
            bench.input.target_position = target;
            bench.command(NEW);
            bench.command(ENABLE);
        };
        give(&mut bench, 10_000);
        if !is_late {
            give(&mut bench, -10_000);
        }
        let demands = |output: &Output, target| matches!(output.demand, Demand::Position { position, .. } if position == target);
        bench.until(|output| demands(output, 10_000));
        bench.input.position_actual = place;
        if is_late {
            give(&mut bench, -10_000);
        }
        let has_reached = |output: &Output| has(output.statusword, statusword::TARGET_REACHED);
        let until = |output: &Output| has_reached(output) || !demands(output, 10_000);
        let periods = bench.until(until) + if is_late { 2 } else { 0 };
        assert_eq!(periods, wait, "{place}");
        // Bit 10 is set for one period, and the next begins the motion.
        assert!(!has_reached(&bench.step()));
        assert!(!demands(&bench.step(), 10_000));
        bench.until(|output| demands(output, -10_000));
    }
}

#[test]
fn a_set_point_long_after_the_motor_has_come_to_rest_outside_the_window_starts_at_once() {
    let mut bench = Bench::enabled(Mode::ProfilePosition);
    bench.follows = false;
    bench.input.target_position = 10_000;
    bench.command(NEW);
    bench.command(ENABLE);
    bench.until(|output| {
        matches!(
            output.demand,
            Demand::Position {
                position: 10_000,
                ..
            }
        )
    });
    bench.run(300);
    bench.input.target_position = -10_000;
    let output = bench.command(NEW);
    assert!(matches!(
        output.demand,
        Demand::Position {
            position: ..10_000,
            ..
        }
    ));
}

#[test]
fn relative_set_points_continue_from_the_position_limit_where_the_last_one_ended() {
    let mut bench = Bench::enabled(Mode::ProfilePosition);
    for (way, end) in [(50_000, 50_000), (30_000, 60_000), (-20_000, 40_000)] {
        bench.input.target_position = way;
        bench.command(NEW | controlword::RELATIVE);
        bench.command(ENABLE);
        bench.until(|output| has(output.statusword, statusword::TARGET_REACHED));
        assert_eq!(bench.input.position_actual, end);
    }
}

#[test]
fn a_cyclic_position_is_approached_at_most_at_the_velocity_of_607fh() {
    let mut bench = Bench::enabled(Mode::CyclicPosition);
    bench.parameters.max_velocity = 50_000;
    bench.input.target_position = 20_000;
    // 200 mdeg a period, with the limit reported until the last.
    for period in 1..=100 {
        let output = bench.step();
        let demand = Demand::Position {
            position: period * 200,
            velocity: 50_000,
        };
        assert_eq!(output.demand, demand);
        assert_eq!(
            has(output.statusword, statusword::INTERNAL_LIMIT),
            period < 100
        );
    }
}

#[test]
fn change_set_immediately_replaces_the_active_set_point() {
    let mut bench = Bench::enabled(Mode::ProfilePosition);
    bench.input.target_position = 50_000;
    bench.command(NEW);
    bench.command(ENABLE);
    bench.run(9);
    bench.input.target_position = -5_000;
    bench.command(NEW | controlword::CHANGE_SET_IMMEDIATELY);
    bench.until(|output| has(output.statusword, statusword::TARGET_REACHED));
    assert_eq!(bench.input.position_actual, -5_000);
}

#[test]
fn relative_set_points_are_added() {
    let mut bench = Bench::enabled(Mode::ProfilePosition);
    bench.input.target_position = 4_000;
    for _ in 0..2 {
        bench.command(NEW | controlword::RELATIVE);
        bench.command(ENABLE);
    }
    for end in [4_000, 8_000] {
        bench.until(|output| has(output.statusword, statusword::TARGET_REACHED));
        assert_eq!(bench.input.position_actual, end);
        bench.step();
    }
}

#[test]
fn targets_are_limited_to_the_software_position_limits() {
    for mode in [Mode::ProfilePosition, Mode::CyclicPosition] {
        let mut bench = Bench::enabled(mode);
        bench.input.target_position = 70_000;
        bench.command(NEW);
        let mut limited = false;
        for _ in 0..200 {
            limited |= has(bench.command(ENABLE).statusword, statusword::INTERNAL_LIMIT);
            assert!(bench.input.position_actual <= 60_000);
        }
        assert!(limited);
        assert_eq!(bench.input.position_actual, 60_000);
    }
}

#[test]
fn velocity_modes_stop_before_the_software_position_limits_and_may_return() {
    for mode in [Mode::ProfileVelocity, Mode::CyclicVelocity] {
        let mut bench = Bench::enabled(mode);
        bench.input.target_velocity = 300_000;
        for _ in 0..200 {
            bench.step();
            assert!(bench.input.position_actual <= 60_000);
        }
        assert!(
            bench.input.position_actual > 59_000,
            "{}",
            bench.input.position_actual
        );
        bench.input.target_velocity = -100_000;
        bench.run(100);
        assert!(bench.input.position_actual < 59_000);
    }
}

#[test]
fn cyclic_positions_are_interpolated_over_the_interpolation_period() {
    let mut bench = Bench::enabled(Mode::CyclicPosition);
    let mut seen = Vec::new();
    for target in [1_000, 2_000, 2_000] {
        bench.input.target_position = target;
        for _ in 0..5 {
            if let Demand::Position { position, velocity } = bench.step().demand {
                seen.push((position, velocity));
            }
        }
    }
    let expected: Vec<_> = (1..=10)
        .map(|at| (at * 200, 50_000))
        .chain([(2_000, 0); 5])
        .collect();
    assert_eq!(seen, expected, "200 mdeg in each 4 ms");
}

#[test]
fn cyclic_velocity_adds_its_offset_and_is_limited() {
    let mut bench = Bench::enabled(Mode::CyclicVelocity);
    bench.parameters.position_limits = None;
    (bench.input.target_velocity, bench.input.velocity_offset) = (100_000, 20_000);
    let output = bench.step();
    assert_eq!(output.demand, Demand::Velocity(120_000));
    assert!(
        has(output.statusword, statusword::MODE_12),
        "it follows the command"
    );
    bench.input.target_velocity = 600_000;
    let output = bench.step();
    assert_eq!(output.demand, Demand::Velocity(500_000));
    assert!(has(output.statusword, statusword::INTERNAL_LIMIT));
}

/// The offsets in effect behind a control period with this controlword.
fn offsets(bench: &mut Bench, word: u16, velocity: i32, torque: i16) -> (i32, i16) {
    bench.command(word);
    let wanted = Offsets { velocity, torque };
    let acts = bench.axis.offsets(wanted, &bench.parameters);
    (acts.velocity, acts.torque)
}

#[test]
fn offsets_of_cyclic_modes_act_while_enabled_that_of_the_velocity_behind_the_first_target() {
    let mut bench = Bench::new(Mode::CyclicPosition);
    bench.writes(false);
    for (word, torque) in [(0, 0), (6, 0), (7, 0), (ENABLE, 300), (ENABLE, 300)] {
        assert_eq!(offsets(&mut bench, word, 50_000, 300), (0, torque));
    }
    bench.writes(true);
    for (wanted, expected) in [
        ((50_000, 300), (50_000, 300)),
        ((-600_000, -2_000), (-500_000, -1_000)),
    ] {
        let found = offsets(&mut bench, ENABLE, wanted.0, wanted.1);
        assert_eq!(found, expected, "607Fh and 6072h");
    }
    let halt = ENABLE | controlword::HALT;
    assert_eq!(offsets(&mut bench, halt, 50_000, 300), (0, 300));
    for mode in MODES {
        bench.input.mode = mode;
        bench.run(2);
        let expected = match mode {
            Mode::CyclicPosition => (50_000, 300),
            Mode::CyclicVelocity => (0, 300),
            _ => (0, 0),
        };
        let found = offsets(&mut bench, ENABLE, 50_000, 300);
        assert_eq!(found, expected, "{mode:?}");
    }
}

#[test]
fn a_velocity_offset_holds_no_shaft_beyond_a_position_limit() {
    let mut bench = Bench::enabled(Mode::CyclicPosition);
    bench.parameters.position_limits = Some((-60_000, 60_000));
    // The position loop's gain of 8 per second in 2^-10.
    bench.parameters.approach_gain = 8 << 10;
    for (target, offset, most) in [
        (60_000, 50_000, 0),
        (-60_000, -50_000, 0),
        (60_000, -50_000, -50_000),
        (59_000, 50_000, 8_000),
        (-59_500, -50_000, -4_000),
    ] {
        bench.input.target_position = target;
        bench.run(300);
        let (velocity, _) = offsets(&mut bench, ENABLE, offset, 0);
        assert_eq!(velocity, most, "{target} {offset}");
    }
}

#[test]
fn profile_velocity_reports_target_reached_and_zero_speed() {
    let mut bench = Bench::enabled(Mode::ProfileVelocity);
    bench.parameters.position_limits = None;
    bench.run(10);
    assert!(has(bench.step().statusword, statusword::MODE_12));
    bench.input.target_velocity = 120_000;
    // 10 periods of acceleration and 20 ms in the window.
    let periods = bench.until(|output| {
        has(output.statusword, statusword::TARGET_REACHED)
            && !has(output.statusword, statusword::MODE_12)
    });
    assert!((15..=17).contains(&periods), "{periods}");
}

#[test]
fn a_following_error_is_reported_after_its_time_out() {
    let mut bench = Bench::enabled(Mode::CyclicPosition);
    bench.follows = false;
    bench.input.target_position = 6_000;
    let periods = bench.until(|output| output.following_error_exceeded);
    // Above 5 deg in the fifth period, then 200 ms.
    assert_eq!(periods, 5 + 50);
    let output = bench.step();
    assert_eq!(output.following_error, 6_000);
    assert!(has(output.statusword, statusword::FOLLOWING_ERROR));
    bench.input.position_actual = 2_000;
    assert!(!bench.step().following_error_exceeded);
    bench.parameters.following_error_window = u32::MAX;
    bench.input.position_actual = -60_000;
    (0..100).for_each(|_| assert!(!bench.step().following_error_exceeded));
}

#[test]
fn a_position_outside_the_window_is_not_target_reached() {
    let mut bench = Bench::enabled(Mode::ProfilePosition);
    bench.input.target_position = 10_000;
    bench.command(NEW);
    bench.until(|output| has(output.statusword, statusword::TARGET_REACHED));
    bench.follows = false;
    bench.input.position_actual = 10_501;
    assert!(!has(bench.step().statusword, statusword::TARGET_REACHED));
    bench.input.position_actual = 10_500;
    let periods = bench.until(|output| has(output.statusword, statusword::TARGET_REACHED));
    assert_eq!(periods, 6, "20 ms in the window");
}

#[test]
fn a_target_acts_once_it_is_written_after_the_mode_has_started() {
    for mode in [
        Mode::CyclicPosition,
        Mode::CyclicVelocity,
        Mode::ProfileVelocity,
    ] {
        let mut bench = Bench::new(mode);
        (
            bench.input.target_position,
            bench.input.target_velocity,
            bench.input.velocity_offset,
        ) = (9_000, 70_000, 7_000);
        for word in [0, 6, 7] {
            bench.command(word);
        }
        // The target that comes with the controlword that enables operation is from before.
        let first = bench.command(ENABLE);
        bench.writes(false);
        bench.run(50);
        assert_eq!(bench.input.position_actual, 0, "{mode:?}");
        assert!(!has(first.statusword, statusword::MODE_12) || mode == Mode::ProfileVelocity);
        // The same values, written again.
        bench.writes(true);
        bench.step();
        bench.writes(false);
        bench.run(50);
        assert!(bench.input.position_actual >= 9_000, "{mode:?}");
    }
}

#[test]
fn a_cyclic_mode_needs_a_new_target_after_a_halt_and_a_profile_resumes() {
    for mode in [
        Mode::CyclicPosition,
        Mode::CyclicVelocity,
        Mode::ProfileVelocity,
    ] {
        let mut bench = Bench::enabled(mode);
        bench.input.target_position = 2_000;
        bench.input.target_velocity = 50_000;
        bench.run(3);
        bench.writes(false);
        bench.command(ENABLE | controlword::HALT);
        bench.run(50);
        let place = bench.input.position_actual;
        bench.command(ENABLE);
        bench.run(50);
        let has_moved = bench.input.position_actual != place;
        assert_eq!(has_moved, mode == Mode::ProfileVelocity, "{mode:?}");
    }
}

#[test]
fn a_change_of_mode_continues_from_the_actual_position() {
    let mut bench = Bench::enabled(Mode::CyclicVelocity);
    bench.input.target_velocity = 100_000;
    bench.run(50);
    let place = bench.input.position_actual;
    bench.input.mode = Mode::ProfilePosition;
    bench.step();
    bench.run(50);
    assert!(
        (bench.input.position_actual - place).abs() < 2_500,
        "it stops within its deceleration"
    );
}
