use super::*;

const STEP_NS: i64 = 4_000_000;

fn instants(count: usize) -> Vec<i64> {
    (0..count as i64).map(|i| i * STEP_NS).collect()
}

fn at(segments: &[Segment], time_ns: i64) -> f64 {
    Reader::new(segments).at(time_ns)
}

#[test]
fn a_step_is_held_from_its_sample_on() {
    let mut command = vec![0.0; 50];
    command[20..].fill(90.0);
    let segments = segments(&instants(50), &command, Hold::Auto);
    assert_eq!(segments.len(), 2);
    assert_eq!(segments[1], Segment::constant(20 * STEP_NS, 90.0));
    assert_eq!(at(&segments, 20 * STEP_NS - 1), 0.0);
}

#[test]
fn a_sine_of_25_samples_a_period_is_met_between_its_samples() {
    let omega = std::f64::consts::TAU * 10.0;
    let sine = |ns: i64| 5.0 * (omega * ns as f64 * 1e-9).sin();
    let command: Vec<f64> = instants(500).iter().map(|t| sine(*t)).collect();
    let segments = segments(&instants(500), &command, Hold::Auto);
    for i in 50..1900 {
        let time_ns = i * STEP_NS / 4;
        // Inside: 5 (w h)^4 5/384 at most, 2.6e-4; the error of a straight line is 4e-2.
        assert!((at(&segments, time_ns) - sine(time_ns)).abs() < 3e-4, "{i}");
    }
}

#[test]
fn the_corners_of_a_ramp_are_preserved() {
    let level = |i: usize| -> f64 {
        match i {
            0..40 => 0.0,
            40..80 => 0.24 * (i - 40) as f64,
            80..120 => 9.6 - 0.24 * (i - 80) as f64,
            _ => 0.0,
        }
    };
    let command: Vec<f64> = (0..160).map(level).collect();
    let segments = segments(&instants(160), &command, Hold::Auto);
    for i in 0..159 {
        let middle = at(&segments, i as i64 * STEP_NS + STEP_NS / 2);
        assert!(
            (middle - (command[i] + command[i + 1]) / 2.0).abs() < 1e-9,
            "{i}"
        );
    }
}

#[test]
fn a_command_with_few_levels_is_held_even_if_every_sample_differs() {
    let command: Vec<f64> = (0..200).map(|i| f64::from(i * 7 % 3)).collect();
    let segments = segments(&instants(200), &command, Hold::Auto);
    assert!(segments.iter().all(|s| s.is_constant));
}

#[test]
fn a_missing_command_repeats_the_previous_one() {
    let command = [f64::NAN, 1.0, f64::NAN, 2.0, f64::NAN];
    assert_eq!(filled(&command), [1.0, 1.0, 1.0, 2.0, 2.0]);
}

#[test]
fn any_command_becomes_a_zero_order_hold_on_request() {
    let command: Vec<f64> = (0..100).map(|i| f64::from(i).sin()).collect();
    let held = segments(&instants(100), &command, Hold::Zero);
    assert_eq!(held.len(), 100);
    assert_eq!(at(&held, 10 * STEP_NS + 1), command[10]);
    let smooth = segments(&instants(100), &command, Hold::Smooth);
    assert!(smooth.iter().all(|s| !s.jumps || s.start_ns == 0));
}
