//! Jerk-limited profiles, interpolated positions, relative set-points.

use canopen::cia402::{Demand, Mode, RelativeTo, controlword, statusword};

use crate::{Bench, ENABLE, NEW};

/// The position demands of a move of 60 deg until bit 10 is set.
fn demands(smoothing: u8) -> Vec<i64> {
    let mut bench = Bench::enabled(Mode::ProfilePosition);
    bench.parameters.smoothing = smoothing;
    (
        bench.parameters.position_limits,
        bench.parameters.position_window_time_ms,
    ) = (None, 0);
    bench.input.target_position = 60_000;
    let mut demands = vec![0; 3];
    bench.input.controlword = NEW;
    for _ in 0..1_000 {
        let output = bench.step();
        let Demand::Position { position, .. } = output.demand else {
            panic!("powered");
        };
        demands.push(position.into());
        if output.statusword & statusword::TARGET_REACHED != 0 {
            return demands;
        }
    }
    panic!("the target is not reached");
}

/// The greatest magnitudes of the first three differences.
fn greatest(demands: &[i64]) -> [i64; 3] {
    let mut values = demands.to_vec();
    [0; 3].map(|_| {
        values = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
        values.iter().map(|value| value.abs()).max().unwrap_or(0)
    })
}

#[test]
fn a_mean_limits_the_jerk_and_takes_its_own_time_longer() {
    let trapezoidal = demands(0);
    let [velocity, acceleration, jerk] = greatest(&trapezoidal);
    // 300 deg/s, 3000 deg/s^2, and that within a period: by the rounding of a demand.
    assert_eq!((velocity, acceleration), (1_200, 48));
    assert!(jerk >= 48);
    for periods in [2_u8, 10, 16] {
        let smooth = demands(periods);
        let [velocity, acceleration, jerk] = greatest(&smooth);
        assert!(
            velocity <= 1_201 && acceleration <= 50,
            "{velocity} {acceleration}"
        );
        // The rounding of four demands, half a unit each with 1, 3, 3 and 1.
        let limit = 48 / i64::from(periods) + 4;
        assert!(jerk <= limit, "{periods}: {jerk}");
        // The last period of the trapezoidal profile may be one without a way.
        let longer = smooth.len() - trapezoidal.len();
        assert!(
            (1..=2).contains(&(usize::from(periods) - longer)),
            "{longer}"
        );
        assert!(smooth.is_sorted(), "no overshoot");
    }
}

#[test]
fn a_smooth_motion_stops_resumes_and_changes_its_target_without_a_step() {
    let mut bench = Bench::enabled(Mode::ProfilePosition);
    bench.parameters.smoothing = 15;
    bench.input.target_position = 50_000;
    bench.command(NEW);
    let mut places = vec![];
    for at in 0..400 {
        let word = match at {
            20..40 => ENABLE | controlword::HALT,
            60 => NEW | controlword::CHANGE_SET_IMMEDIATELY,
            _ => ENABLE,
        };
        if at == 60 {
            bench.input.target_position = -20_000;
        }
        bench.command(word);
        places.push(i64::from(bench.input.position_actual));
    }
    assert_eq!(places.last(), Some(&-20_000));
    let [_, acceleration, _] = greatest(&places);
    assert!(acceleration <= 50, "{acceleration}");
}

#[test]
fn a_jerk_limit_that_begins_in_motion_continues_its_velocity() {
    let mut bench = Bench::enabled(Mode::ProfilePosition);
    bench.input.target_position = 60_000;
    bench.command(NEW);
    let mut places = vec![];
    for at in 0..200 {
        // At 300 deg/s, and again with another mean.
        bench.parameters.smoothing = match at {
            0..30 => 0,
            30..40 => 10,
            _ => 15,
        };
        bench.command(ENABLE);
        places.push(i64::from(bench.input.position_actual));
    }
    assert_eq!(places.last(), Some(&60_000));
    let [velocity, acceleration, _] = greatest(&places);
    assert!(
        velocity <= 1_201 && acceleration <= 50,
        "{velocity} {acceleration}"
    );
}

#[test]
fn a_set_point_at_the_present_position_is_reached_as_early_with_a_jerk_limit_as_without() {
    let periods = [0, 10].map(|smoothing| {
        let mut bench = Bench::enabled(Mode::ProfilePosition);
        bench.parameters.smoothing = smoothing;
        bench.parameters.position_window_time_ms = 0;
        bench.input.target_position = bench.input.position_actual;
        bench.input.controlword = NEW;
        bench.until(|output| output.statusword & statusword::TARGET_REACHED != 0)
    });
    assert_eq!(periods[0], periods[1]);
}

#[test]
fn points_are_followed_while_bit_4_is_set() {
    let mut bench = Bench::enabled(Mode::InterpolatedPosition);
    let has_bit_12 = |word: u16| word & statusword::MODE_12 != 0;
    bench.input.target_position = 10_000;
    let waiting = bench.step();
    assert!(!has_bit_12(waiting.statusword));
    assert_eq!(bench.input.position_actual, 0);
    // 20 ms at 4 ms.
    let interpolate = ENABLE | controlword::INTERPOLATE;
    let first = bench.command(interpolate);
    assert!(has_bit_12(first.statusword));
    bench.run(4);
    assert_eq!(bench.input.position_actual, 10_000);
    bench.input.target_position = 12_000;
    bench.run(2);
    assert_eq!(bench.input.position_actual, 10_800, "two of five steps");
    let off = bench.command(ENABLE);
    assert!(!has_bit_12(off.statusword));
    bench.run(50);
    let stopped = bench.input.position_actual;
    // 100 deg/s at 3000 deg/s^2.
    assert!((12_200..12_470).contains(&stopped), "{stopped}");
    // A point from before does not count: it needs one that is new.
    bench.input.is_new_position = false;
    bench.command(interpolate);
    bench.run(20);
    assert_eq!(bench.input.position_actual, stopped);
}

#[test]
fn a_relative_set_point_is_added_to_what_60f2h_selects() {
    for (relative_to, expected) in [
        (RelativeTo::Target, 25_000),
        (RelativeTo::Demand, 15_000),
        (RelativeTo::Actual, 14_000),
    ] {
        let mut bench = Bench::enabled(Mode::ProfilePosition);
        bench.parameters.relative_to = relative_to;
        bench.input.target_position = 20_000;
        bench.command(NEW);
        bench.command(ENABLE);
        let reaches = |position| move |output: &canopen::cia402::Output| matches!(output.demand, Demand::Position { position: at, .. } if at >= position);
        bench.until(reaches(10_000));
        bench.follows = false;
        let demand = bench.input.position_actual;
        bench.input.position_actual = demand - 1_000;
        bench.input.target_position = 5_000;
        bench.command(NEW | controlword::RELATIVE | controlword::CHANGE_SET_IMMEDIATELY);
        bench.follows = true;
        bench.input.controlword = ENABLE;
        bench.run(300);
        let off = bench.input.position_actual - (expected + demand - 10_000);
        let is_target = relative_to == RelativeTo::Target;
        let off = if is_target {
            off + demand - 10_000
        } else {
            off
        };
        assert_eq!(off, 0, "{relative_to:?}");
    }
}
