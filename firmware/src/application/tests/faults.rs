//! Every fault, provoked; detected and safe within its stated times.

use std::vec::Vec;

use model_core::{
    control::{
        encoder_word::Magnet,
        units::{Percent, angle, percent, rate},
    },
    sensors::{
        adc::AdcCode,
        dividers::{leg_code, supply_code, temperature_code},
    },
};

use super::*;
use crate::faults::{FaultDescription, TABLE, Watched};

/// The code of a motor current.
fn current(current_ma: i32) -> AdcCode {
    AdcCode::from_pin_v(1.65 + 0.5 * f64::from(current_ma) / 1000.0)
}

fn scan(samples: &mut Samples) -> &mut Scan {
    samples.scan.as_mut().expect("scanned")
}

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
            scan(samples).leg_a = leg_code(4.0);
        }
        Fault::EncoderJump => {
            samples.encoder = Some(word(
                count
                    .wrapping_add(1000)
                    .wrapping_add(317u16.wrapping_mul(since as u16)),
            ))
        }
        Fault::OverCurrent => samples.current = Some(current(-1640)),
        Fault::Overload => samples.current = Some(current(1010)),
        Fault::BridgeTripped => samples.bridge_tripped = true,
        Fault::Stall => {
            *samples = Samples::at_rest(word(0));
            samples.current = Some(current(700));
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

/// A board that is about to meet a fault.
fn prepared(fault: Fault) -> TestBoard {
    let mut board = match fault {
        // At rest it would be a stall.
        Fault::Overload | Fault::MotorPolarity => TestBoard::turning(),
        _ => TestBoard::enabled(),
    };
    match fault {
        Fault::CommandTimeout => {
            board.command = None;
        }
        Fault::FollowingError => {
            board.application.set_ripple(smooth());
            board.command = Some(angle(30.0));
        }
        Fault::CurrentImplausible => board.command = Some(angle(9.0)),
        Fault::Overload => board.application.set_ripple(smooth()),
        // The controller pulls, within the window of the following error.
        Fault::Stall => {
            board.application.set_ripple(smooth());
            board.command = Some(angle(5.0));
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
        let p = *board.application.parameters();
        let (mut detected, mut safe) = (None, None);
        for since in 1..1000 {
            let outputs = board.step_with(|samples| provoke(fault, samples, since));
            let ms = since * 4;
            if outputs.fault.is_some() && detected.is_none() {
                assert_eq!(outputs.fault, Some(fault), "{}", row.name);
                detected = Some(ms);
            }
            if outputs.state == BoardState::Fault {
                let coasts = matches!(fault, Fault::OverCurrent | Fault::BridgeTripped);
                let off = if coasts { Bridge::Coast } else { Bridge::Brake };
                assert_eq!(outputs.bridge, off, "{}", row.name);
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
        let mut board = TestBoard::new(BoardParameters::DEFAULT);
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
    let last = board.application.faults().last().unwrap();
    assert_eq!(last.fault, Fault::EncoderInvalid);
}

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
    // At 5.73 V the current of the on time would be too large: the motor is shorted for a period.
    let outputs = board.step_with(|samples| samples.encoder = None);
    assert_eq!(outputs.state, BoardState::FaultReaction);
    assert_eq!(outputs.telemetry.duty, Percent::ZERO);
    let outputs = board.step_with(|samples| samples.encoder = None);
    let back_emf_mv = f64::from(outputs.telemetry.back_emf_mv);
    assert!(back_emf_mv > 5000.0, "{back_emf_mv} mV");
    let duty_pct = outputs.telemetry.duty.to_f64();
    assert!(
        (duty_pct + 75.0 * back_emf_mv / 5998.0).abs() < 0.01,
        "{duty_pct} %"
    );
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
            (Application::new(BoardParameters::DEFAULT), Motor::new());
        let mut step = || {
            let mut samples = motor.samples();
            cut(&mut samples);
            application.step(&samples)
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

/// The rates in each period of the stop, deg/s, of a motor at the full rate whose encoder is lost,
/// with legs that are connected rightly or the wrong way round.
fn stop_without_encoder(legs_swapped: bool) -> Vec<f64> {
    let mut board = TestBoard::turning();
    let break_wire = |samples: &mut Samples| {
        samples.encoder = None;
        if legs_swapped {
            let scan = scan(samples);
            core::mem::swap(&mut scan.leg_a, &mut scan.leg_b);
        }
    };
    let mut rates = Vec::new();
    while board.step_with(break_wire).state != BoardState::Fault {
        if board.outputs.state == BoardState::FaultReaction {
            rates.push(board.rate_deg_s());
        }
        assert!(rates.len() < 1000, "it does not end");
    }
    assert_eq!(board.outputs.bridge, Bridge::Brake);
    rates
}

#[test]
fn a_shaft_without_encoder_is_brought_to_rest_by_its_back_emf() {
    let rates = stop_without_encoder(false);
    let last = *rates.last().expect("a stop");
    assert!(last.abs() < 5.0, "{last} deg/s");
    // The duty that opposes the back-EMF of 20.2 mV per deg/s divides the plant's time constant
    // by 1 + 0.75 * 5.73/5.998. Then 20 ms at rest. Two periods are left for
    // the delay of the duty and the resolution of a period.
    let time_constant_s = without_stop().motor_time_constant_s / (1.0 + 0.75 * 5.73 / 5.998);
    let decay_s = (283.6_f64 / 5.0).ln() * time_constant_s;
    let periods = decay_s / 0.004 + 5.0;
    let difference = rates.len() as f64 - periods;
    assert!(difference.abs() < 2.0, "{} periods, {periods}", rates.len());
}

#[test]
fn a_back_emf_of_the_wrong_sign_does_not_accelerate_the_shaft() {
    // The current is soon implausible, and the motor brakes.
    let rates = stop_without_encoder(true);
    assert!(rates.len() > 10, "{rates:?}");
    assert!(
        rates.is_sorted_by(|before, after| before > after),
        "{rates:?}"
    );
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
fn a_missing_sample_holds_the_counter_of_a_condition() {
    let mut board = TestBoard::enabled();
    let over = |samples: &mut Samples| samples.current = Some(current(1640));
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
fn overload_comes_after_its_time_at_twice_the_current_and_never_at_the_continuous_one() {
    let periods_at = |current_ma| {
        let mut board = TestBoard::turning();
        board.application.set_ripple(smooth());
        (1..5000).find(|_| {
            let outputs = board.step_with(|samples| samples.current = Some(current(current_ma)));
            outputs.fault == Some(Fault::Overload)
        })
    };
    assert_eq!(periods_at(495), None);
    // 2 s, a little less for what the code rounds up.
    assert!((490..=501).contains(&periods_at(1000).unwrap()));
    // 780 mA: 3 * 0.25/(0.61 - 0.25) * 2 s = 4.2 s.
    assert!((1030..1060).contains(&periods_at(780).unwrap()));
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
    board.application.set_ripple(smooth());
    let mut periods = 0;
    while board.outputs.fault.is_none() && periods < 200 {
        periods += 1;
        board.step_with(|samples| {
            *samples = Samples::at_rest(word(periods % 2));
            samples.current = Some(current(600));
        });
    }
    assert_eq!((board.outputs.fault, periods), (Some(Fault::Stall), 125));
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
