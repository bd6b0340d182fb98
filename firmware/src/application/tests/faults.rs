//! Every fault, provoked; detected and safe within its stated times.

use std::vec::Vec;

use model_core::{
    control::{
        encoder_word::Magnet,
        units::{angle, rate},
    },
    sensors::{
        adc::AdcCode,
        dividers::{leg_code, supply_code, temperature_code},
    },
};

use super::*;
use crate::faults::{FaultDescription, TABLE, Watched};

/// Does in each control period what provokes a fault; `since` counts them.
fn provoke(fault: Fault, samples: &mut Samples, since: u32) {
    let count = samples.encoder.and_then(|word| word.read().ok());
    let count = count.map_or(0, |reading| reading.count.get());
    match fault {
        Fault::EncoderInvalid => {
            samples.encoder = samples.encoder.map(|w| EncoderWord::new(w.bits() ^ 1))
        }
        Fault::MagnetLost => {
            samples.encoder = Some(EncoderWord::of(EncoderCount::new(count), Magnet::Lost))
        }
        Fault::MagnetWeak => {
            samples.encoder = Some(EncoderWord::of(EncoderCount::new(count), Magnet::Marginal))
        }
        Fault::EncoderStuck => {
            samples.encoder = Some(word(0));
            // A back-EMF of 1 V, and its current.
            scan(samples).leg_a = leg_code(4.0);
            samples.current = Some(current(-130));
        }
        Fault::EncoderJump => {
            samples.encoder = Some(word(
                count
                    .wrapping_add(1000)
                    .wrapping_add(317u16.wrapping_mul(since as u16)),
            ))
        }
        // Three counts a control period, 66 deg/s, of a motor at rest.
        Fault::EncoderImplausible => {
            *samples = Samples::at_rest(word(3u16.wrapping_mul(since as u16)));
        }
        Fault::OverCurrent => samples.current = Some(current(-2040)),
        // By the limit that `parameters` sets.
        Fault::Overload => {}
        Fault::BridgeTripped => samples.bridge_tripped = true,
        Fault::Stall => {
            *samples = Samples::at_rest(word(0));
            samples.current = Some(current(550));
        }
        // Held, at a current between that of a free motor and that of a stall.
        Fault::FollowingError => {
            *samples = Samples::at_rest(word(0));
            samples.current = Some(current(300));
        }
        // Held, and no current.
        Fault::CurrentImplausible => {
            *samples = Samples::at_rest(word(0));
        }
        // The legs of a motor that turns the other way.
        Fault::MotorPolarity => {
            let scan = scan(samples);
            core::mem::swap(&mut scan.leg_a, &mut scan.leg_b);
        }
        Fault::UnderVoltage => scan(samples).supply = supply_code(3.8),
        Fault::OverVoltage => scan(samples).supply = supply_code(9.2),
        Fault::OverTemperature => scan(samples).temperature = temperature_code(90.0),
        Fault::MeasurementLost => scan(samples).temperature = AdcCode::MAX,
        Fault::LoopOverrun => samples.missed_periods = 4,
        Fault::BusOff => samples.bus = BusState::Off,
        Fault::CommandTimeout | Fault::ParametersCorrupt | Fault::WatchdogReset => {}
        // Detected by the board's program, outside the application.
        Fault::DataCorrupt | Fault::ProgramCorrupt => {}
    }
}

/// The parameters with which [`provoke`] causes a fault.
fn parameters(fault: Fault) -> BoardParameters {
    let mut parameters = BoardParameters::DEFAULT;
    if fault == Fault::Overload {
        parameters.current.winding_mdeg_c = 20_000;
    }
    parameters
}

/// A board that is about to meet a fault.
fn prepared(fault: Fault) -> TestBoard {
    let mut board = match fault {
        Fault::MotorPolarity => TestBoard::turning_at(90.0),
        _ => TestBoard::enabled(),
    };
    match fault {
        Fault::CommandTimeout => {
            board.command = None;
        }
        Fault::FollowingError => {
            board.application.motor.ripple = smooth();
            board.command = Some(angle(30.0));
        }
        Fault::CurrentImplausible => board.command = Some(angle(9.0)),
        Fault::Overload => board.application.parameters = parameters(fault),
        // The controller pulls, within the window of the following error.
        Fault::Stall => {
            board.application.motor.ripple = smooth();
            board.command = Some(angle(9.0));
        }
        _ => {}
    }
    board
}

#[test]
fn every_fault_is_latched_and_safe_within_its_times() {
    let of_program = [Fault::DataCorrupt, Fault::ProgramCorrupt];
    let is_detected_here =
        |row: &&FaultDescription| row.watched != Watched::Start && !of_program.contains(&row.fault);
    for row in TABLE.iter().filter(is_detected_here) {
        let fault = row.fault;
        let mut board = prepared(fault);
        let p = board.application.parameters;
        let (mut detected, mut safe) = (None, None);
        for since in 1..1000 {
            let outputs = board.step_with(|samples| provoke(fault, samples, since));
            let ms = since * 4;
            if outputs.fault.is_some() && detected.is_none() {
                assert_eq!(outputs.fault, Some(fault), "{}", row.name);
                detected = Some(ms);
            }
            if outputs.state == BoardState::FaultHold {
                assert!(p.holding_faults().contains(fault), "{}", row.name);
                safe = Some(ms + 1);
                break;
            }
            if outputs.state == BoardState::Fault {
                let coasts = matches!(fault, Fault::OverCurrent | Fault::BridgeTripped);
                assert_eq!(coasts, outputs.bridge == Bridge::Coast, "{}", row.name);
                assert_ne!(coasts, is_braked(&outputs), "{}", row.name);
                safe = Some(ms + 1);
                break;
            }
        }
        let (detected, safe) = (detected.expect(row.name), safe.expect(row.name));
        assert!(
            detected <= fault.detected_ms(&p),
            "{}: {detected} ms",
            row.name
        );
        assert!(safe <= fault.safe_ms(&p), "{}: {safe} ms", row.name);
    }
}

#[test]
fn faults_of_driving_block_enabling_while_the_board_is_disabled_and_are_not_latched() {
    for row in TABLE.iter().filter(|row| row.watched == Watched::Driven) {
        let fault = row.fault;
        let mut board = TestBoard::new(parameters(fault));
        for since in 1..700 {
            let outputs = board.step_with(|samples| provoke(fault, samples, since));
            assert_eq!(
                (outputs.state, outputs.fault),
                (BoardState::Disabled, None),
                "{}",
                row.name
            );
        }
        // A shaft that stands, and a shaft that is elsewhere, are no news where nothing drives it.
        // Without a drive there is neither an expected current nor a direction.
        if matches!(
            fault,
            Fault::Stall | Fault::EncoderJump | Fault::CurrentImplausible | Fault::MotorPolarity
        ) {
            continue;
        }
        assert!(
            board.outputs.telemetry.present.contains(fault),
            "{}",
            row.name
        );
        let refused = board.application.request(Request::Enable);
        assert_eq!(refused, Err(Refused::Blocked(fault)), "{}", row.name);
    }
}

#[test]
fn a_fault_stays_until_it_is_acknowledged_and_then_wants_a_new_enable() {
    let mut board = TestBoard::enabled();
    // Four periods until it is detected, and 20 ms of a stop in which the shaft already rests.
    for _ in 0..4 + 5 {
        board.step_with(|samples| provoke(Fault::EncoderInvalid, samples, 1));
    }
    assert_eq!(board.outputs.fault, Some(Fault::EncoderInvalid));
    let refused = Err(Refused::State(BoardState::Fault));
    assert_eq!(board.application.request(Request::Enable), refused);
    assert_eq!(board.step().state, BoardState::Fault);
    board.request(Request::Acknowledge);
    assert_eq!(board.application.state(), BoardState::Disabled);
    assert_eq!(board.step().fault, None);
    board.request(Request::Enable);
    assert_eq!(board.step().state, BoardState::Enabled);
}

/// Control periods for which this has to last until a turning board stops.
fn periods_until(fault: Fault) -> u32 {
    let mut board = TestBoard::turning();
    let mut since = 0;
    while board.outputs.state == BoardState::Enabled {
        board.step_with(|samples| provoke(fault, samples, since));
        since += 1;
    }
    since
}

#[test]
fn a_fault_that_stops_the_shaft_by_the_ramp_leaves_a_quick_stop_on_its_ramp() {
    let mut board = TestBoard::turning();
    for since in 0..periods_until(Fault::OverTemperature) - 5 {
        board.step_with(|samples| provoke(Fault::OverTemperature, samples, since));
    }
    board.request(Request::QuickStop);
    let mut hot = || {
        board
            .step_with(|samples| provoke(Fault::OverTemperature, samples, 0))
            .state
    };
    let states: Vec<_> = (0..10).map(|_| hot()).collect();
    let (quick_stop, reaction) = states.split_at(4);
    assert_eq!(quick_stop, [BoardState::QuickStop; 4]);
    assert_eq!(reaction, [BoardState::FaultReaction; 6]);
    while hot() == BoardState::FaultReaction {}
    assert_eq!(board.outputs.state, BoardState::Fault);
    assert!(board.outputs.telemetry.rate.abs() < rate(5.0));
}

#[test]
fn a_quick_stop_outlasts_its_time_until_the_shaft_rests_and_a_fault_does_not() {
    let mut board = TestBoard::turning();
    let stop = &mut board.application.parameters.stop;
    stop.quick_stop_ms = 100;
    stop.quick_stop_deceleration_deg_s2 = 500;
    // The fault comes 80 periods after the stop has begun, before the ramp has ended.
    let hot = periods_until(Fault::OverTemperature);
    for since in 0..hot {
        if since == hot - 80 {
            board.request(Request::QuickStop);
        }
        let outputs = board.step_with(|samples| provoke(Fault::OverTemperature, samples, since));
        assert_eq!(
            outputs.state == BoardState::QuickStop,
            (hot - 80..hot - 1).contains(&since)
        );
    }
    assert_eq!(board.outputs.fault, Some(Fault::OverTemperature));
    assert_eq!(board.outputs.state, BoardState::Fault);
    assert!(is_braked(&board.outputs));
}

#[test]
fn a_second_fault_that_stops_the_shaft_by_the_ramp_leaves_the_first_on_its_ramp() {
    let delays = [Fault::OverTemperature, Fault::MagnetWeak].map(|f| (f, periods_until(f)));
    let longest = delays[0].1.max(delays[1].1);
    let mut board = TestBoard::turning();
    // The second one is latched three periods after the first one.
    for period in 0..longest + 5 {
        board.step_with(|samples| {
            for (number, (fault, delay)) in delays.into_iter().enumerate() {
                if period >= longest - delay + 3 * number as u32 {
                    provoke(fault, samples, period);
                }
            }
        });
    }
    let latched = board.outputs.telemetry.latched;
    assert!(delays.iter().all(|(fault, _)| latched.contains(*fault)));
    assert_eq!(board.outputs.state, BoardState::FaultReaction);
}

#[test]
fn a_fault_that_coasts_ends_a_quick_stop_at_once() {
    let mut board = TestBoard::turning();
    board.command = None;
    for _ in 0..26 {
        board.step();
    }
    assert_eq!(board.outputs.state, BoardState::FaultReaction);
    assert_eq!(board.outputs.fault, Some(Fault::CommandTimeout));
    let outputs = board.step_with(|samples| samples.bridge_tripped = true);
    assert_eq!(outputs.state, BoardState::Fault);
    // The cause is still the first one.
    assert_eq!(outputs.fault, Some(Fault::CommandTimeout));
    assert!(outputs.telemetry.latched.contains(Fault::BridgeTripped));
}

#[test]
fn what_lasted_before_the_loop_was_closed_does_not_count_towards_a_fault_of_the_motion() {
    for fault in [
        Fault::Stall,
        Fault::FollowingError,
        Fault::EncoderStuck,
        Fault::CurrentImplausible,
        Fault::MotorPolarity,
    ] {
        let provoked = |board: &mut TestBoard, periods: u32| {
            (1..=periods).find(|&since| {
                let outputs = board.step_with(|samples| provoke(fault, samples, since));
                outputs.fault.is_some()
            })
        };
        let whole = provoked(&mut prepared(fault), 1000).expect("a fault");
        let mut board = prepared(fault);
        assert_eq!(provoked(&mut board, whole - 1), None, "{fault:?}");
        // No control period runs while the loop is open.
        board.request(Request::Disable);
        board.request(Request::Enable);
        // One period less where the first one had no rate command yet.
        let again = provoked(&mut board, whole).expect("a fault");
        assert!(again + 1 >= whole, "{fault:?}: {again} of {whole}");
        assert_eq!(board.outputs.fault, Some(fault));
    }
}

#[test]
fn the_position_of_an_encoder_that_was_wrong_is_not_kept() {
    for fault in [Fault::EncoderStuck, Fault::EncoderImplausible] {
        let mut board = prepared(fault);
        for since in 1..1000 {
            if board.outputs.state == BoardState::Fault {
                break;
            }
            board.step_with(|samples| provoke(fault, samples, since));
        }
        assert_eq!(board.outputs.fault, Some(fault));
        assert!(board.application.control.shaft().is_known());
        board.request(Request::Acknowledge);
        assert!(!board.application.control.shaft().is_known(), "{fault:?}");
    }
}
