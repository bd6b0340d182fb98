//! Where commands come from, and how one source follows another.

use model_core::{
    control::units::{Angle, angle},
    excitation::{
        Excitation,
        chirp::{Chirp, ChirpParameters},
        multistep::{DoubletParameters, Multistep},
    },
};

use super::*;
use crate::command::excitation::{Run, Sample};

fn pulse(width_us: u16) -> impl Fn(&mut Samples) {
    move |samples| samples.servo_pulse_us = Some(width_us)
}

#[test]
fn a_command_of_the_bus_is_followed_at_once() {
    let mut board = TestBoard::enabled();
    board.command = Some(angle(30.0));
    assert_eq!(board.step().telemetry.command, angle(30.0));
    board.steps(500);
    assert!((board.outputs.telemetry.angle - angle(30.0)).abs() < angle(0.2));
}

#[test]
fn the_servo_pulse_is_approached_slowly_and_followed_at_once_from_there_on() {
    let mut board = TestBoard::enabled();
    board.request(Request::Source(CommandSource::ServoPulse));
    board.command = None;
    // 2000 us are 60 deg: a second at 60 deg/s.
    let mut last = board.outputs.telemetry.command;
    for _ in 0..260 {
        let command = board.step_with(pulse(2000)).telemetry.command;
        assert!(command - last <= angle(0.241), "{last} {command}");
        last = command;
    }
    assert_eq!(last, angle(60.0));
    assert_eq!(board.step_with(pulse(1000)).telemetry.command, angle(-60.0));
    assert_eq!(board.outputs.telemetry.source, CommandSource::ServoPulse);
}

#[test]
fn commands_of_the_bus_are_refused_while_the_servo_pulse_commands() {
    let mut board = TestBoard::enabled();
    board.request(Request::Source(CommandSource::ServoPulse));
    let refused = Err(Refused::Source(CommandSource::ServoPulse));
    let request = Request::Command(angle(1.0).into());
    assert_eq!(board.application.request(request), refused);
}

#[test]
fn back_on_the_bus_the_command_stays_until_the_next_one() {
    let mut board = TestBoard::enabled();
    board.request(Request::Source(CommandSource::ServoPulse));
    board.command = None;
    for _ in 0..100 {
        board.step_with(pulse(1750));
    }
    let reached = board.outputs.telemetry.command;
    assert!(reached > angle(20.0));
    board.request(Request::Source(CommandSource::Bus));
    assert_eq!(board.step().telemetry.command, reached);
    board.command = Some(angle(-5.0));
    assert_eq!(board.step().telemetry.command, angle(-5.0));
}

#[test]
fn invalid_pulses_are_counted_and_do_not_keep_the_command_alive() {
    let mut board = TestBoard::enabled();
    board.request(Request::Source(CommandSource::ServoPulse));
    board.command = None;
    board.step_with(pulse(1500));
    let command = board.outputs.telemetry.command;
    for _ in 0..25 {
        let outputs = board.step_with(pulse(3000));
        assert_eq!((outputs.fault, outputs.telemetry.command), (None, command));
    }
    let outputs = board.step_with(pulse(100));
    assert_eq!(outputs.fault, Some(Fault::CommandTimeout));
    assert_eq!(outputs.telemetry.servo_glitches, 26);
    assert_eq!(outputs.telemetry.servo_pulse_us, 1500);
}

#[test]
fn an_excitation_is_added_to_the_command_and_ends_where_it_began() {
    let mut board = TestBoard::enabled();
    board.command = Some(angle(10.0));
    board.steps(300);
    board.command = None;
    let doublet = Multistep::try_doublet(&DoubletParameters {
        amplitude_deg: 2.0,
        start_s: 0.0,
        unit_s: 0.1,
    });
    let run = Run::new(Excitation::Multistep(doublet.unwrap()), 2);
    board.application.start_excitation(run).unwrap();
    for _ in 0..2 {
        // 0.2 s are 50 control periods, and the tick at the end is one more.
        for period in 0..51 {
            let outputs = board.step();
            let expected = match period {
                0..25 => 12,
                25..50 => 8,
                _ => 10,
            };
            assert_eq!(
                outputs.telemetry.command,
                Angle::from_int(expected),
                "{period}"
            );
            assert_eq!(outputs.telemetry.source, CommandSource::Excitation);
        }
    }
    let outputs = board.step();
    assert_eq!(outputs.telemetry.command, angle(10.0));
    assert_eq!(outputs.telemetry.source, CommandSource::Bus);
}

#[test]
fn an_excitation_that_is_ended_leaves_the_command_where_it_is() {
    let mut board = TestBoard::enabled();
    let chirp = Chirp::try_linear(&Default::default()).unwrap();
    let run = Run::new(Excitation::Chirp(chirp), 1);
    board.application.start_excitation(run).unwrap();
    board.command = None;
    // The timeout of commands does not run meanwhile.
    board.steps(300);
    assert_eq!(board.outputs.fault, None);
    let command = board.outputs.telemetry.command;
    assert_ne!(command, Angle::ZERO);
    board.request(Request::StopExcitation);
    assert_eq!(board.step().telemetry.command, command);
}

/// Commands of an excitation that repeats itself, with what `meanwhile` does after each control
/// period.
fn commands(run: Run, meanwhile: impl Fn(&mut Application, usize)) -> [Angle; 120] {
    let mut board = TestBoard::enabled();
    board.command = None;
    board.application.start_excitation(run).unwrap();
    core::array::from_fn(|period| {
        let command = board.step().telemetry.command;
        meanwhile(&mut board.application, period);
        command
    })
}

#[test]
fn samples_that_were_computed_elsewhere_make_the_same_commands() {
    let chirp = ChirpParameters {
        duration_s: 0.2,
        ..Default::default()
    };
    let chirp = Chirp::try_linear(&chirp).unwrap();
    let run = Run::new(Excitation::Chirp(chirp), 2);
    let alone = commands(run, |_, _| {});
    let offered = commands(run, |application, period| {
        let Some(tick) = application.sample_due() else {
            return;
        };
        match period % 3 {
            // In time, late by a period, and not at all.
            0 => application.take_sample(run.sample(tick)),
            1 => application.take_sample(run.sample(tick.saturating_sub(80))),
            _ => {}
        }
        assert_eq!(application.sample_due().is_none(), period % 3 == 0);
    });
    assert_eq!(offered, alone);
    // What is offered is what is taken.
    let wrong = Sample {
        tick: 80,
        angle: angle(1.0),
    };
    let led_astray = commands(run, |application, _| application.take_sample(wrong));
    assert_ne!(led_astray, alone);
}

#[test]
fn the_sample_of_the_next_control_period_is_due_until_it_is_taken() {
    let chirp = Chirp::try_linear(&Default::default()).unwrap();
    let mut board = TestBoard::enabled();
    let run = Run::new(Excitation::Chirp(chirp), 1);
    board.application.start_excitation(run).unwrap();
    board.step();
    // 4 ms in steps of 1/20,000 s.
    assert_eq!(board.application.sample_due(), Some(80));
    board.application.take_sample(run.sample(80));
    assert_eq!(board.application.sample_due(), None);
}

#[test]
fn an_excitation_starts_in_the_enabled_state_only() {
    let mut board = TestBoard::new(BoardParameters::DEFAULT);
    let chirp = Chirp::try_linear(&Default::default()).unwrap();
    let run = Run::new(Excitation::Chirp(chirp), 1);
    let refused = Err(Refused::State(BoardState::Disabled));
    assert_eq!(board.application.start_excitation(run), refused);
}

#[test]
fn without_a_fresh_servo_pulse_the_loop_is_not_closed() {
    let mut board = TestBoard::new(BoardParameters::DEFAULT);
    board.request(Request::Source(CommandSource::ServoPulse));
    let blocked = Err(Refused::Blocked(Fault::CommandTimeout));
    assert_eq!(board.application.request(Request::Enable), blocked);
    board.step_with(pulse(1700));
    assert_eq!(board.application.request(Request::Enable), Ok(()));
    board.request(Request::Disable);
    // It grows stale.
    board.steps(30);
    assert_eq!(board.application.request(Request::Enable), blocked);
}

#[test]
fn a_timeout_of_zero_switches_the_timeout_off() {
    let mut parameters = BoardParameters::DEFAULT;
    parameters.command.command_timeout_ms = 0;
    let mut board = TestBoard::new(parameters);
    board.request(Request::Enable);
    board.steps(1000);
    assert_eq!(board.outputs.state, BoardState::Enabled);
}
