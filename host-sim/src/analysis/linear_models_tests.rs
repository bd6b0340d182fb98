use super::super::referee::Board;
use super::*;
use num_complex::Complex64;
use proptest::prelude::*;
use std::f64::consts::TAU;

/// The motor's sampled response to the held and delayed duty as a sum of impulse responses: an
/// independent computation of its transfer function, for |z| > 1.
fn summed(motor: &Motor, timing: &Timing, z: Complex64) -> Complex64 {
    let (tau, period) = (motor.motor_time_constant_s, timing.control_period_s);
    let step = |t: f64| {
        let t = (t - timing.duty_delay_s).max(0.0);
        motor.motor_gain * (t - tau * (1.0 - (-t / tau).exp()))
    };
    (1..4000)
        .map(|k| (step(f64::from(k) * period) - step(f64::from(k - 1) * period)) / z.powi(k))
        .sum()
}

proptest! {
    #[test]
    fn the_sampled_motor_is_the_sum_of_its_responses(
        motor_time_constant_s in 0.01..1.0f64,
        delay_periods in 0.0..3.0f64,
        angle in 0.0..3.1f64,
    ) {
        let motor = Motor { motor_time_constant_s, ..Motor::default() };
        let timing = Timing { duty_delay_s: 0.004 * delay_periods, ..Timing::default() };
        let z = Complex64::from_polar(1.02, angle);
        let (numerator, denominator) = sampled_motor(&motor, &timing);
        let x = (z - 1.0) / timing.control_period_s;
        let found = numerator.at(x) / denominator.at(x);
        let expected = summed(&motor, &timing, z);
        // The truncated tail of the sum is 1.02^-4000 = 4e-35. Each angle of the step response is
        // the difference of numbers up to 3 deg, rounded to 1e-15; about 50 of them contribute.
        let tolerance = 1e-9 * expected.norm() + 1e-13;
        let error = (found - expected).norm();
        prop_assert!(error < tolerance, "{} of {}", error, expected.norm());
    }

    #[test]
    fn stability_by_poles_agrees_with_the_time_response(
        speed in 0.3..17.0f64,
        share in 0.1..1.0f64,
        rate_filter in 0.1..1.0f64,
        delay_ticks in 1..=80u32,
    ) {
        let tau = Motor::default().motor_time_constant_s;
        let control = ControlParameters {
            position_gain: share * speed * 28.36,
            proportional_gain: speed * 10.0 * tau,
            integral_gain: speed * 10.0,
            rate_filter,
            ..ControlParameters::default()
        };
        let timing = Timing { duty_delay_s: 50e-6 * f64::from(delay_ticks), ..Timing::default() };
        let at_gain = |gain: f64| {
            let motor = Motor { motor_gain: 2.836 * gain, ..Motor::default() };
            Loop::sampled(&motor, &control, &timing).unwrap().closed.is_stable()
        };
        // Within three per cent of its stability limit a loop takes longer to settle or to diverge.
        prop_assume!(at_gain(0.97) == at_gain(1.03));
        let board = Board { control, timing, linear: true, gain: 1.0, ..Board::default() };
        prop_assert_eq!(board.settles(4.0), at_gain(1.0));
    }
}

#[test]
fn a_board_with_a_short_period_approaches_the_grey_box() {
    let control = ControlParameters::default();
    let grey = Loop::continuous(&Motor::default(), &control).unwrap();
    let timing = Timing {
        control_period_s: 1e-4,
        duty_delay_s: 0.0,
    };
    let board = Loop::sampled(&Motor::default(), &control, &timing).unwrap();
    for frequency_hz in [0.01, 0.1, 1.0, 10.0] {
        let ratio = board.closed.at(frequency_hz) / grey.closed.at(frequency_hz);
        // Hold, difference and filter delay by 0.05 + 0.05 + 0.15 ms; the phase error is w times
        // that.
        let bound = TAU * frequency_hz * 2.6e-4 + 1e-6;
        assert!((ratio - 1.0).norm() < bound, "{ratio} at {frequency_hz} Hz");
    }
}

#[test]
fn the_grey_box_agrees_with_the_closed_form_of_the_papers_numbers() {
    // F G = 28.36/s and P = 8: 226.88/(s^2 + 28.36 s + 226.88).
    let grey = Loop::continuous(&Motor::default(), &ControlParameters::default()).unwrap();
    let closed_form = black_box_2(226.88, 28.36);
    for frequency_hz in [0.1, 1.0, 1.68, 10.0] {
        let ratio = grey.closed.at(frequency_hz) / closed_form.at(frequency_hz);
        assert!((ratio - 1.0).norm() < 1e-12);
    }
}

#[test]
fn without_integral_gain_the_loop_is_still_stable_and_without_position_gain_it_is_not() {
    let stable = |control: ControlParameters| {
        let board = Loop::sampled(&Motor::default(), &control, &Timing::default()).unwrap();
        board.closed.is_stable()
    };
    let control = ControlParameters::default();
    assert!(stable(ControlParameters {
        integral_gain: 0.0,
        ..control
    }));
    assert!(!stable(ControlParameters {
        position_gain: 0.0,
        ..control
    }));
}

#[test]
fn feed_forward_gives_a_faster_response() {
    let control = ControlParameters {
        feed_forward_gain: 1.0 / 2.836,
        ..Default::default()
    };
    let with = Loop::sampled(&Motor::default(), &control, &Timing::default()).unwrap();
    let without =
        Loop::sampled(&Motor::default(), &Default::default(), &Timing::default()).unwrap();
    assert!((with.closed.steady_gain() - 1.0).abs() < 1e-9);
    assert!(with.closed.at(1.0).arg() > without.closed.at(1.0).arg());
}

#[test]
fn the_error_of_an_invalid_parameter_gives_its_value_and_range() {
    let refuse = |motor: Motor, timing: Timing| {
        Loop::sampled(&motor, &ControlParameters::default(), &timing)
            .unwrap_err()
            .to_string()
    };
    let motor = Motor {
        motor_time_constant_s: f64::NAN,
        ..Motor::default()
    };
    let text = refuse(motor, Timing::default());
    assert_eq!(
        text,
        "motor_time_constant_s is NaN, expected a number from 0.0001 to 100 s"
    );
    let timing = Timing {
        control_period_s: 0.004,
        duty_delay_s: 0.05,
    };
    let text = refuse(Motor::default(), timing);
    assert_eq!(
        text,
        "duty_delay_s is 0.05, expected a number from 0 to 0.032 s"
    );
}

#[test]
fn an_asymmetric_motor_has_two_gains() {
    let plant = FirstOrderParameters {
        motor_gain_up: 2.4,
        motor_gain_down: 3.5,
        ..Default::default()
    };
    assert_eq!(Motor::upward(&plant).motor_gain, 2.4);
    assert_eq!(Motor::downward(&plant).motor_gain, 3.5);
    assert_eq!(Motor::downward(&plant).motor_time_constant_s, 1.0 / 7.586);
}
