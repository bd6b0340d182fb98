//! Operating states and the ways between them.

use model_core::control::{
    parameters::ControlParameters,
    units::{Rate, angle, percent, rate},
};

use super::*;
use crate::parameters::Parameter;

#[test]
fn the_loop_is_not_closed_before_everything_was_measured() {
    type Cut = fn(&mut Samples);
    let cuts: [Cut; 2] = [
        |samples| samples.scan = None,
        |samples| samples.current = None,
    ];
    for cut in cuts {
        let mut application = Configured::new(BoardParameters::DEFAULT);
        let mut samples = Samples::at_rest(word(0));
        cut(&mut samples);
        assert_eq!(
            application.control_period(&samples).state,
            BoardState::Initialising
        );
        let refused = Refused::State(BoardState::Initialising);
        assert_eq!(application.request(Request::Enable), Err(refused));
        let outputs = application.control_period(&Samples::at_rest(word(0)));
        assert_eq!(outputs.state, BoardState::Disabled);
        assert_eq!(application.request(Request::Enable), Ok(()));
    }
}

#[test]
fn what_cannot_be_measured_within_200_ms_of_the_start_is_a_fault() {
    let mut application = Configured::new(BoardParameters::DEFAULT);
    let mut samples = Samples::at_rest(word(0));
    samples.encoder = None;
    for _ in 0..49 {
        assert_eq!(
            application.control_period(&samples).state,
            BoardState::Initialising
        );
    }
    let outputs = application.control_period(&samples);
    assert_eq!(
        (outputs.state, outputs.fault),
        (BoardState::Fault, Some(Fault::EncoderInvalid))
    );
}

#[test]
fn a_watchdog_reset_and_corrupt_parameters_are_faults_of_the_start() {
    for (start, fault) in [
        (
            Start {
                watchdog: true,
                ..Start::default()
            },
            Fault::WatchdogReset,
        ),
        (
            Start {
                parameters_corrupt: true,
                ..Start::default()
            },
            Fault::ParametersCorrupt,
        ),
    ] {
        let mut application = Configured::after(BoardParameters::DEFAULT, start);
        let outputs = application.control_period(&Samples::at_rest(word(0)));
        assert_eq!(
            (outputs.state, outputs.fault),
            (BoardState::Fault, Some(fault))
        );
        assert_eq!(application.request(Request::Acknowledge), Ok(()));
        let outputs = application.control_period(&Samples::at_rest(word(0)));
        assert_eq!((outputs.state, outputs.fault), (BoardState::Disabled, None));
    }
}

#[test]
fn a_corrupt_program_remains_a_fault_after_every_acknowledgement() {
    let start = Start {
        program_corrupt: true,
        ..Start::default()
    };
    let mut application = Configured::after(BoardParameters::DEFAULT, start);
    for _ in 0..3 {
        let outputs = application.control_period(&Samples::at_rest(word(0)));
        assert_eq!(
            (outputs.state, outputs.fault),
            (BoardState::Fault, Some(Fault::ProgramCorrupt))
        );
        assert_eq!(application.request(Request::Acknowledge), Ok(()));
        assert_eq!(
            application.request(Request::Enable),
            Err(Refused::Blocked(Fault::ProgramCorrupt))
        );
    }
}

#[test]
fn after_a_reset_in_motion_the_motor_brakes_while_the_board_initialises() {
    let unmeasured = Samples {
        encoder: None,
        ..Samples::at_rest(word(0))
    };
    let first = |start| {
        let outputs =
            Configured::after(BoardParameters::DEFAULT, start).control_period(&unmeasured);
        assert_eq!(outputs.state, BoardState::Initialising);
        outputs.bridge
    };
    let watchdog = Start {
        watchdog: true,
        ..Start::default()
    };
    assert_eq!(first(watchdog), Bridge::Brake);
    assert_eq!(first(Start::default()), Bridge::Brake);
}

#[test]
fn after_a_reset_in_motion_the_board_initialises_until_the_shaft_rests() {
    let mut motor = Motor::new();
    let mut before = TestBoard::turning();
    core::mem::swap(&mut motor, &mut before.motor);
    let mut board = Configured::new(BoardParameters::DEFAULT);
    loop {
        let outputs = board.control_period(&motor.samples());
        if outputs.state != BoardState::Initialising {
            break;
        }
        assert!(is_braked(&outputs));
        motor.turn(&outputs);
    }
    assert_eq!(board.state(), BoardState::Disabled);
    // A count a period is 22 deg/s: the estimate of half of that falls below 5 deg/s in between.
    let rate_deg_s = motor.plant.at(20).rate_deg_s;
    assert!(rate_deg_s < 11.0, "{rate_deg_s} deg/s");
}

#[test]
fn every_request_that_does_not_fit_the_state_is_refused_and_changes_nothing() {
    let mut disabled = TestBoard::new(BoardParameters::DEFAULT);
    for request in [Request::QuickStop, Request::Acknowledge] {
        let refused = Err(Refused::State(BoardState::Disabled));
        assert_eq!(disabled.application.request(request), refused);
    }
    let mut enabled = TestBoard::enabled();
    let refused = Err(Refused::State(BoardState::Enabled));
    assert_eq!(enabled.application.request(Request::Acknowledge), refused);
    assert_eq!(enabled.application.request(Request::Enable), Ok(()));
    assert_eq!(enabled.application.state(), BoardState::Enabled);
    let refused = Err(Refused::Source(CommandSource::Excitation));
    let request = Request::Source(CommandSource::Excitation);
    assert_eq!(enabled.application.request(request), refused);
}

#[test]
fn a_disabled_bridge_is_off_and_the_integrator_empty() {
    let mut board = TestBoard::enabled();
    board.command = Some(angle(10.0));
    board.steps(100);
    board.request(Request::Disable);
    assert_eq!(board.step().bridge, Bridge::Coast);
    // At rest, with the angle as the command, there is no duty.
    board.steps(500);
    board.command = None;
    board.request(Request::Enable);
    let outputs = board.step();
    assert_eq!(outputs.state, BoardState::Enabled);
    assert!(outputs.telemetry.duty.abs() < percent(1e-6));
}

#[test]
fn enabling_holds_the_angle_wherever_the_last_command_was() {
    let mut board = TestBoard::enabled();
    board.command = Some(angle(90.0));
    board.steps(60);
    board.request(Request::Disable);
    board.steps(500);
    let held = board.outputs.telemetry.angle;
    board.command = None;
    board.request(Request::Enable);
    board.steps(20);
    assert_eq!(board.outputs.telemetry.command, held);
    assert_eq!(board.outputs.telemetry.angle, held);
}

#[test]
fn a_quick_stop_brings_the_shaft_to_rest_by_the_ramp_and_goes_off() {
    let mut board = TestBoard::turning();
    let before = board.outputs.telemetry;
    board.request(Request::QuickStop);
    let mut periods = 0;
    while board.outputs.state != BoardState::Disabled {
        let outputs = board.step();
        periods += 1;
        // 2000 deg/s^2 are 8 deg/s a period.
        let ramp = (before.rate - Rate::from_int(8 * periods)).max(Rate::ZERO);
        if ramp > Rate::ZERO {
            assert_eq!(outputs.telemetry.rate_command, ramp, "{periods}");
        }
    }
    // 283 deg/s take 36 periods; the shaft follows within some more.
    assert!((36 + 5..=100).contains(&periods), "{periods}");
    assert!(board.outputs.telemetry.rate.abs() < rate(5.0));
    assert_eq!(board.outputs.bridge, Bridge::Coast);
    // v^2/2a = 20 deg, and what the lag adds.
    let way = board.outputs.telemetry.angle - before.angle;
    assert!(way > angle(18.0) && way < angle(45.0), "{way}");
}

#[test]
fn a_quick_stop_starts_without_a_jump_of_the_duty() {
    let mut board = TestBoard::turning();
    let before = board.outputs.telemetry.duty;
    board.request(Request::QuickStop);
    let after = board.step().telemetry.duty;
    // From 100 % to the 95.5 % of the back-EMF; 8 deg/s less at 1.32 %/(deg/s), and what the
    // integrator makes of it.
    assert!((after - before).abs() < percent(16.0), "{before} {after}");
}

#[test]
fn a_quick_stop_that_holds_stays_until_it_is_enabled_or_disabled() {
    let mut parameters = BoardParameters::DEFAULT;
    parameters.stop.quick_stop_hold = 1;
    let mut board = TestBoard::new(parameters);
    board.request(Request::Enable);
    board.command = Some(angle(500.0));
    board.steps(100);
    board.request(Request::QuickStop);
    board.steps(150);
    assert_eq!(board.outputs.state, BoardState::QuickStop);
    let held = board.outputs.telemetry.angle;
    board.steps(500);
    assert_eq!(board.outputs.state, BoardState::QuickStop);
    assert!((board.outputs.telemetry.angle - held).abs() < angle(2.0));
    board.command = None;
    board.request(Request::Enable);
    assert_eq!(board.step().state, BoardState::Enabled);
    board.request(Request::QuickStop);
    board.request(Request::Disable);
    assert_eq!(board.step().state, BoardState::Disabled);
}

#[test]
fn a_shaft_that_is_turned_away_from_where_a_quick_stop_holds_it_is_driven_back() {
    let mut parameters = BoardParameters::DEFAULT;
    parameters.stop.quick_stop_hold = 1;
    let mut board = TestBoard::enabled_with(parameters);
    board.request(Request::QuickStop);
    board.steps(10);
    // 16 counts are 1.41 deg, and the position gain is 8/s.
    for _ in 0..3 {
        board.step_with(|samples| samples.encoder = Some(word(16)));
        let command = board.outputs.telemetry.rate_command;
        assert!((command + rate(11.25)).abs() < rate(0.01), "{command}");
    }
    assert_eq!(board.outputs.state, BoardState::QuickStop);
}

#[test]
fn other_gains_while_the_loop_is_closed_do_not_move_the_duty() {
    let stiffer = with_gains(ControlParameters {
        proportional_gain: 3.0,
        position_gain: 12.0,
        ..ControlParameters::DEFAULT
    });
    let (mut kept, mut retuned) = (TestBoard::enabled(), TestBoard::enabled());
    // A shaft that is held, so that what is measured is the same in both periods.
    let held = |board: &mut TestBoard| {
        board.step_with(|samples| {
            samples.encoder = Some(word(16));
            turn(samples, 0.0);
        })
    };
    for board in [&mut kept, &mut retuned] {
        board.command = Some(angle(5.0));
        for _ in 0..20 {
            held(board);
        }
    }
    assert_eq!(retuned.application.retune(&stiffer), Ok(()));
    let apart = held(&mut retuned).telemetry.duty - held(&mut kept).telemetry.duty;
    // What is left of the filtered rate after 20 periods: 440 deg/s 0.6^20, times 3 %/(deg/s).
    assert!(apart.abs() < percent(0.05), "{apart}");
    // From there on the new gains act: 12/s instead of 8/s at 3 deg and 10 %/deg are 0.5 % a
    // period.
    for _ in 0..5 {
        held(&mut retuned);
        held(&mut kept);
    }
    let apart = held(&mut retuned).telemetry.duty - held(&mut kept).telemetry.duty;
    assert!(apart > percent(2.0), "{apart}");
}

#[test]
fn parameters_beyond_the_control_step_wait_until_the_bridge_is_off() {
    let mut other = BoardParameters::DEFAULT;
    other.stall.stall_ms = 600;
    let mut board = TestBoard::enabled();
    assert_eq!(
        board.application.retune(&other),
        Err(Refused::NotWhileDriving)
    );
    // The encoder's zero and sense: the shaft would jump, or run away.
    for (number, value) in [(12, 10.0), (13, -1.0)] {
        let mut turned = BoardParameters::DEFAULT;
        assert!(turned.control.set(number, value));
        let refused = Err(Refused::NotWhileDriving);
        assert_eq!(board.application.retune(&turned), refused);
    }
    board.request(Request::QuickStop);
    let mut gains = BoardParameters::DEFAULT;
    assert!(gains.control.set(0, 9.0));
    assert_eq!(
        board.application.retune(&gains),
        Err(Refused::NotWhileDriving)
    );
    board.request(Request::Disable);
    assert_eq!(board.application.retune(&other), Ok(()));
    other.stall.stall_ms = 0;
    assert_eq!(
        board.application.retune(&other),
        Err(Refused::Parameter(Parameter::StallMs))
    );
}

#[test]
fn missed_periods_are_counted_and_leave_no_jump_in_the_rate() {
    let mut board = TestBoard::turning();
    let before = board.outputs.telemetry.rate;
    // Two periods pass without a step.
    for _ in 0..8 {
        board.motor.drift();
    }
    let outputs = board.step_with(|samples| samples.missed_periods = 2);
    assert_eq!(outputs.telemetry.missed_periods, 2);
    assert_eq!(outputs.fault, None);
    let jump = outputs.telemetry.rate - before;
    // A count a period is 22 deg/s; over three periods and with a share of 0.4 a tenth of that.
    assert!(jump.abs() < rate(9.0), "{jump}");
}

#[test]
fn a_bridge_that_trips_while_the_board_initialises_is_latched_and_coasts() {
    let mut board = Configured::new(BoardParameters::DEFAULT);
    let outputs = board.control_period(&Samples {
        encoder: None,
        bridge_tripped: true,
        ..Samples::at_rest(word(0))
    });
    assert_eq!(outputs.fault, Some(Fault::BridgeTripped));
    assert_eq!(
        (outputs.state, outputs.bridge),
        (BoardState::Fault, Bridge::Coast)
    );
}

/// Control periods that a board initialises whose back-EMF is that of this rate, deg/s, and whose
/// encoder turns by so many counts a period, for 500 periods.
fn initialising_periods(rate_deg_s: f64, counts: u16) -> u32 {
    let mut board = Configured::new(BoardParameters::DEFAULT);
    let mut periods = 0;
    loop {
        let mut samples = Samples::at_rest(word(periods.min(500) as u16 * counts % 4096));
        turn(&mut samples, if periods < 500 { rate_deg_s } else { 0.0 });
        periods += 1;
        if board.control_period(&samples).state != BoardState::Initialising {
            return periods;
        }
    }
}

#[test]
fn the_board_waits_until_the_shaft_rests_and_for_an_offset_of_the_legs_40_ms() {
    assert_eq!(initialising_periods(0.0, 0), 1);
    assert_eq!(initialising_periods(10.0, 0), 10);
    assert_eq!(initialising_periods(90.0, 4), 501);
}

#[test]
fn a_back_emf_that_lies_while_the_shaft_is_held_does_not_turn_it_after_the_fault() {
    let mut board = TestBoard::turning();
    board.command = Some(board.outputs.telemetry.angle);
    board.steps(300);
    // The legs show 2.9 V from now on, whatever the motor does.
    let lie = |samples: &mut Samples| turn(samples, 145.0);
    while board.step_with(lie).state != BoardState::Fault {}
    let begin = board.outputs.telemetry.angle;
    for _ in 0..500 {
        board.step_with(lie);
    }
    assert!(
        board.rate_deg_s().abs() < 1.0,
        "{} deg/s",
        board.rate_deg_s()
    );
    let way = board.outputs.telemetry.angle - begin;
    assert!(way.abs() < angle(45.0), "{way} deg");
}

#[test]
fn a_quick_stop_while_the_motor_accelerates_does_not_turn_the_shaft_back() {
    // Bare, and with the inertia of a load.
    for inertia in [1.0, 2.0, 4.0] {
        for accelerated in (2..90).step_by(2) {
            let mut board = TestBoard::enabled();
            let mut plant = without_stop();
            plant.motor_time_constant_s *= inertia;
            board.motor.plant = FirstOrder::try_new(plant, Pwm::Average).unwrap();
            board.command = Some(angle(30_000.0));
            board.steps(accelerated);
            board.request(Request::QuickStop);
            board.command = None;
            // The duty does not exceed the back-EMF any more: no current accelerates the shaft.
            let first = board.step().telemetry;
            let share_pct = f64::from(first.back_emf_mv) / f64::from(first.supply_mv) * 100.0;
            let duty_pct = first.duty.to_f64();
            assert!(
                first.rate < rate(5.0) || duty_pct <= share_pct + 1.0,
                "{duty_pct} % of {share_pct} %"
            );
            let mut furthest = 0.0_f64;
            while board.step().state == BoardState::QuickStop {
                furthest = furthest.max(board.motor.plant.at(20).angle_deg);
            }
            let back = furthest - board.motor.plant.at(20).angle_deg;
            assert!(
                back < 0.5,
                "{back} deg, {inertia} times, {accelerated} periods"
            );
        }
    }
}
