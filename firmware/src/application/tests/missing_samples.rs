//! Periods without samples, and a motor without its encoder.

use std::vec::Vec;

use model_core::control::units::{Percent, angle, percent};

use super::*;

#[test]
fn three_lost_samples_hold_the_duty_and_the_fourth_starts_the_stop_by_the_back_emf() {
    let mut board = TestBoard::turning();
    let driven = board.step().bridge;
    for _ in 0..3 {
        assert_eq!(
            board.step_with(|samples| samples.encoder = None).bridge,
            driven
        );
    }
    let outputs = board.step_with(|samples| samples.encoder = None);
    assert_eq!(outputs.state, BoardState::FaultReaction);
    let back_emf_mv = f64::from(outputs.telemetry.back_emf_mv);
    assert!(back_emf_mv > 5000.0, "{back_emf_mv} mV");
    assert_eq!(outputs.telemetry.duty, percent(-75.0));
}

#[test]
fn a_period_without_a_count_leaves_the_duty_and_the_loop_as_they_are() {
    let mut board = TestBoard::enabled();
    board.command = Some(angle(3.0));
    let before = board.steps(5).telemetry;
    assert!(before.duty > Percent::ZERO && before.duty < percent(100.0));
    let outputs = board.step_with(|samples| samples.encoder = None);
    assert_eq!(outputs.state, BoardState::Enabled);
    assert_eq!(outputs.telemetry.duty, before.duty);
}

#[test]
fn a_missing_sample_holds_the_counter_of_a_condition() {
    let mut board = TestBoard::enabled();
    let over = |samples: &mut Samples| samples.current = Some(current(2040));
    assert_eq!(board.step_with(over).fault, None);
    for _ in 0..3 {
        assert_eq!(
            board.step_with(|samples| samples.current = None).fault,
            None
        );
    }
    assert_eq!(board.step_with(over).fault, Some(Fault::OverCurrent));
    // One that contradicts clears it.
    let mut board = TestBoard::enabled();
    board.step_with(over);
    board.step();
    assert_eq!(board.step_with(over).fault, None);
}

#[test]
fn a_board_that_lacks_samples_at_its_start_has_the_fault_of_those_alone() {
    type Cut = fn(&mut Samples);
    let cuts: [(Cut, Fault, Fault); 2] = [
        (
            |samples| samples.encoder = None,
            Fault::EncoderInvalid,
            Fault::MeasurementLost,
        ),
        (
            |samples| samples.scan = None,
            Fault::MeasurementLost,
            Fault::EncoderInvalid,
        ),
    ];
    for (cut, missing, there) in cuts {
        let (mut application, mut motor) =
            (Configured::new(BoardParameters::DEFAULT), Motor::new());
        let mut step = || {
            let mut samples = motor.samples();
            cut(&mut samples);
            application.control_period(&samples)
        };
        let outputs = core::iter::repeat_with(&mut step)
            .find(|outputs| outputs.state != BoardState::Initialising)
            .unwrap();
        assert_eq!(outputs.state, BoardState::Fault);
        assert!(outputs.telemetry.latched.contains(missing), "{missing:?}");
        assert!(!outputs.telemetry.latched.contains(there), "{there:?}");
    }
}

#[test]
fn a_shaft_that_was_turned_while_the_encoder_was_lost_is_where_the_first_valid_count_is() {
    let mut board = TestBoard::new(BoardParameters::DEFAULT);
    board.steps(5);
    for _ in 0..10 {
        board.step_with(|samples| samples.encoder = None);
    }
    // 120 deg away: a jump, or a turn, for a position that is still known.
    let outputs = board.step_with(|samples| samples.encoder = Some(word(1365)));
    let angle_deg = outputs.telemetry.angle.to_f64();
    assert!(
        (angle_deg - 1365.0 * 360.0 / 4096.0).abs() < 1e-6,
        "{angle_deg} deg"
    );
    assert!(!outputs.telemetry.present.contains(Fault::EncoderJump));
}

#[test]
fn a_shaft_that_was_turned_while_the_encoder_was_away_has_a_new_angle() {
    let mut board = TestBoard::new(BoardParameters::DEFAULT);
    for _ in 0..60 {
        board.step_with(|samples| samples.encoder = None);
    }
    // 200 deg further: within half a turn of zero that is -160 deg.
    let count = 2276;
    let outputs = board.step_with(|samples| samples.encoder = Some(word(count)));
    assert!((outputs.telemetry.angle + angle(160.0)).abs() < angle(0.1));
}

#[test]
fn a_back_emf_that_is_never_measured_is_a_lost_measurement_after_100_ms() {
    let mut board = TestBoard::enabled();
    // The divider of leg A is open.
    let cut = |samples: &mut Samples| scan(samples).leg_a = AdcCode::new(0);
    for _ in 0..24 {
        assert_eq!(board.step_with(cut).fault, None);
    }
    assert_eq!(board.step_with(cut).fault, Some(Fault::MeasurementLost));
}

/// Control periods of a stop by the back-EMF from the full rate, from this `k` on, by the plant's
/// equation: until the duty of `-k e/V` is not below -75 % any more, against 75 %; then with the
/// time constant over `1 + k`, as long as the shaft turns at 5 deg/s.
fn stopping_periods(k: f64) -> f64 {
    // Of the supply, the back-EMF at the full rate is this share.
    let share = 5.73 / 5.998;
    let (full, end) = (283.6, 5.0_f64);
    let unlimited = (0.75 / (k * share) * full).min(full);
    let against = 0.75 / share * full;
    let limited_s = ((full + against) / (unlimited + against)).ln();
    let decay_s = (unlimited / end).ln() / (1.0 + k * share);
    (limited_s + decay_s) * without_stop().motor_time_constant_s / 0.004
}

#[test]
fn a_shaft_without_encoder_is_brought_to_rest_by_its_back_emf() {
    let mut board = TestBoard::turning();
    let mut stop = 0;
    while board.step_with(|samples| samples.encoder = None).state != BoardState::Fault {
        stop += u32::from(board.outputs.state == BoardState::FaultReaction);
        assert!(stop < 1000, "it does not end");
    }
    let last = board.rate_deg_s();
    assert!(last.abs() < 5.0, "{last} deg/s");
    // Then 20 ms at rest. Two periods are left for the delay of the duty, and two for the period in
    // which the motor is shorted, since the current of the on time would be too large.
    let difference = f64::from(stop) - (stopping_periods(4.0) + 5.0);
    assert!(difference.abs() < 4.0, "{stop} periods: {difference}");
}

#[test]
fn exchanged_dividers_do_not_accelerate_the_shaft() {
    let mut board = TestBoard::enabled();
    board.command = Some(Angle::from_int(30_000));
    let exchange = |samples: &mut Samples| {
        let scan = scan(samples);
        core::mem::swap(&mut scan.leg_a, &mut scan.leg_b);
    };
    while board.step_with(exchange).state == BoardState::Enabled {}
    let latched = board.outputs.telemetry.latched;
    assert!(latched.contains(Fault::MotorPolarity), "{latched:?}");
    let mut rates = Vec::new();
    for _ in 0..200 {
        board.step_with(exchange);
        rates.push(board.rate_deg_s());
    }
    // The shorted motor, with the time constant of the plant.
    let slows = rates.is_sorted_by(|before, after| before > after);
    let decay = (-0.8 / without_stop().motor_time_constant_s).exp();
    assert!(slows && rates[199] < 1.1 * decay * rates[0], "{rates:?}");
}

#[test]
fn an_encoder_that_is_lost_during_the_ramp_does_not_extend_the_stop() {
    let mut board = TestBoard::turning();
    // Neither the ramp nor the stop by the back-EMF ends before 100 ms.
    let mut parameters = BoardParameters::DEFAULT;
    parameters.stop.quick_stop_ms = 100;
    parameters.stop.quick_stop_deceleration_deg_s2 = 500;
    board.application.parameters = parameters;
    board.command = None;
    while board.step().state == BoardState::Enabled {}
    let mut states = std::vec![board.outputs.state];
    for period in 0..40 {
        let outputs = board.step_with(|samples| {
            samples.encoder = samples.encoder.filter(|_| period < 12);
        });
        states.push(outputs.state);
    }
    assert!(
        board
            .outputs
            .telemetry
            .latched
            .contains(Fault::EncoderInvalid)
    );
    // In the last of the 25 periods the stop ends.
    let (stop, after) = states.split_at(24);
    assert_eq!(stop, [BoardState::FaultReaction; 24]);
    assert_eq!(after, [BoardState::Fault; 17]);
    assert!(is_braked(&board.outputs));
}

/// An enabled board that loses its encoder at the full rate stops the shaft by its back-EMF, which
/// takes a third of the longest time of a stop.
fn assert_stop_has_its_whole_time(board: &mut TestBoard) {
    assert_eq!(board.steps(300).state, BoardState::Enabled);
    assert!(board.rate_deg_s() > 270.0);
    while board.step_with(|samples| samples.encoder = None).state != BoardState::Fault {}
    assert!(board.rate_deg_s() < 5.0, "{} deg/s", board.rate_deg_s());
}

#[test]
fn a_stop_by_the_back_emf_has_its_whole_time_after_an_earlier_quick_stop() {
    let mut parameters = BoardParameters::DEFAULT;
    // The ramp of the quick stop takes almost all of its time.
    parameters.stop.quick_stop_deceleration_deg_s2 = 600;
    let mut board = TestBoard::turning();
    board.application.parameters = parameters;
    board.request(Request::QuickStop);
    while board.step().state == BoardState::QuickStop {}
    assert_eq!(board.outputs.state, BoardState::Disabled);
    board.request(Request::Enable);
    assert_stop_has_its_whole_time(&mut board);
}

#[test]
fn a_stop_by_the_back_emf_does_not_outlast_a_drive_that_is_disabled_and_enabled_between_two_steps()
{
    let mut board = TestBoard::turning();
    while board.step_with(|samples| samples.encoder = None).state == BoardState::Enabled {}
    assert_eq!(board.steps(25).state, BoardState::FaultReaction);
    for request in [Request::Disable, Request::Acknowledge, Request::Enable] {
        board.request(request);
    }
    assert_stop_has_its_whole_time(&mut board);
}

#[test]
fn an_encoder_that_is_lost_while_the_shaft_is_held_starts_a_stop_of_its_own() {
    let mut parameters = BoardParameters::DEFAULT;
    parameters.stop.quick_stop_hold = 1;
    let mut board = TestBoard::enabled_with(parameters);
    board.request(Request::QuickStop);
    // The stop has ended long ago: the shaft is held.
    assert_eq!(board.steps(200).state, BoardState::QuickStop);
    let mut reaction = 0;
    while board.step_with(|samples| samples.encoder = None).state != BoardState::Fault {
        reaction += u32::from(board.outputs.state == BoardState::FaultReaction);
    }
    // 20 ms at rest.
    assert_eq!(reaction, 4);
}

#[test]
fn without_an_encoder_the_motor_coasts_at_once_where_its_brake_is_excluded() {
    let mut parameters = BoardParameters::DEFAULT;
    parameters.stop.brake_faults = 0;
    let mut board = TestBoard::enabled_with(parameters);
    for _ in 0..4 {
        board.step_with(|samples| samples.encoder = None);
    }
    assert_eq!(
        (board.outputs.bridge, board.outputs.state),
        (Bridge::Coast, BoardState::Fault)
    );
}
