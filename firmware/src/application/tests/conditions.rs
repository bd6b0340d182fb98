//! What the condition of a fault counts as one, and what not.

use model_core::control::units::angle;

use super::*;

#[test]
fn a_single_jump_of_the_encoder_is_passed_over() {
    let mut board = TestBoard::enabled();
    let before = board.step().telemetry;
    let outputs = board.step_with(|samples| samples.encoder = Some(word(1500)));
    assert_eq!(
        (outputs.telemetry.angle, outputs.fault),
        (before.angle, None)
    );
    assert_eq!(board.step().telemetry.angle, before.angle);
}

#[test]
fn an_offset_that_stays_is_a_jump_however_small_beyond_the_reach() {
    for offset in [80, 128, 270, 2000] {
        let mut board = TestBoard::enabled();
        let slipped = |samples: &mut Samples| samples.encoder = Some(word(offset));
        for _ in 0..3 {
            assert_eq!(board.step_with(slipped).fault, None, "{offset}");
        }
        let outputs = board.step_with(slipped);
        assert_eq!(outputs.fault, Some(Fault::EncoderJump), "{offset}");
    }
}

#[test]
fn a_count_that_flickers_hides_no_stall() {
    let mut board = TestBoard::enabled();
    board.application.motor.ripple = smooth();
    board.command = Some(angle(9.0));
    let mut periods = 0;
    while board.outputs.fault.is_none() && periods < 200 {
        periods += 1;
        board.step_with(|samples| {
            *samples = Samples::at_rest(word(periods % 2));
            samples.current = Some(current(550));
        });
    }
    assert_eq!((board.outputs.fault, periods), (Some(Fault::Stall), 125));
}

#[test]
fn a_motor_that_is_not_connected_takes_no_current() {
    let mut board = TestBoard::enabled();
    board.command = Some(angle(9.0));
    let mut periods = 0;
    while board.outputs.fault.is_none() && periods < 200 {
        board.step_with(|samples| *samples = Samples::at_rest(word(0)));
        periods += 1;
    }
    assert_eq!(board.outputs.fault, Some(Fault::CurrentImplausible));
}

#[test]
fn a_rate_limit_below_that_of_the_following_error_is_followed_without_one() {
    let mut parameters = BoardParameters::DEFAULT;
    assert!(parameters.control.set(8, 10.0));
    let mut board = TestBoard::new(parameters);
    board.request(Request::Enable);
    board.command = Some(angle(30.0));
    board.steps(500);
    assert_eq!(board.outputs.fault, None);
    assert!(board.outputs.telemetry.angle > angle(15.0));
}

#[test]
fn four_missed_periods_are_one_too_many_unless_good_ones_lie_between() {
    let mut board = TestBoard::enabled();
    for _ in 0..20 {
        board.step_with(|samples| samples.missed_periods = 1);
        board.steps(250);
    }
    assert_eq!(board.outputs.fault, None);
    for _ in 0..4 {
        board.step_with(|samples| samples.missed_periods = 1);
        board.step();
    }
    assert_eq!(board.outputs.fault, Some(Fault::LoopOverrun));
}

#[test]
fn a_late_step_counts_as_missed_and_leaves_the_rate_alone() {
    let (mut late, mut punctual) = (TestBoard::turning(), TestBoard::turning());
    late.application.was_late();
    assert_eq!(late.step().telemetry.rate, punctual.step().telemetry.rate);
    for _ in 0..3 {
        late.application.was_late();
        late.step();
    }
    assert_eq!(late.outputs.fault, Some(Fault::LoopOverrun));
}

#[test]
fn bus_off_matters_only_where_commands_come_from_the_bus() {
    let mut board = TestBoard::enabled();
    board.request(Request::Source(CommandSource::ServoPulse));
    for _ in 0..50 {
        let outputs = board.step_with(|samples| {
            samples.bus = BusState::Off;
            samples.servo_pulse_us = Some(1500);
        });
        assert_eq!(outputs.fault, None);
    }
}

#[test]
fn bus_off_ends_an_excitation_that_the_bus_has_started() {
    use crate::{command::excitation::Run, parameters::ExcitationSettings};
    let run: Run = ExcitationSettings::DEFAULT.run().unwrap();
    let mut board = TestBoard::enabled();
    board.application.start_excitation(run).unwrap();
    board.steps(10);
    let outputs = board.step_with(|samples| samples.bus = BusState::Off);
    assert_eq!(outputs.fault, Some(Fault::BusOff));
    assert_eq!(outputs.state, BoardState::FaultReaction);
}
