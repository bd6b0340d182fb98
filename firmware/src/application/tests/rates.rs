//! Rate setpoints, and the estimated rate over missed control periods.

use model_core::control::{
    cascade::Setpoint,
    parameters::ControlParameters,
    units::{Rate, rate},
};

use super::*;

fn enabled(parameters: BoardParameters) -> Configured {
    // The samples show no current, and with this resistance none is expected.
    let mut application = Configured::new(parameters);
    application.motor.ripple = Ripple::of(1e3, 1e3);
    application.control_period(&Samples::at_rest(word(1000)));
    application.request(Request::Enable).unwrap();
    application
}

fn command(application: &mut Application, setpoint: Setpoint) {
    application.request(Request::Command(setpoint)).unwrap();
}

#[test]
fn a_stalled_shaft_is_commanded_exactly_the_rate_whatever_the_position_gain() {
    for position_gain in [0.0, 8.0, 500.0] {
        for velocity in [-350.0, -0.5, 3.0, 77.7, 350.0] {
            let mut application = enabled(with_gains(ControlParameters {
                position_gain,
                ..ControlParameters::DEFAULT
            }));
            for _ in 0..20 {
                command(&mut application, rate(velocity).into());
                let outputs = application.control_period(&Samples::at_rest(word(1000)));
                assert_eq!(outputs.state, BoardState::Enabled);
                assert_eq!(outputs.telemetry.rate_command, rate(velocity));
                // A commanded rate has no commanded angle of its own.
                assert_eq!(outputs.telemetry.command, outputs.telemetry.angle);
            }
        }
    }
}

#[test]
fn a_rate_is_reached_and_the_following_error_watches_it() {
    let mut board = TestBoard::enabled();
    board.command = None;
    for _ in 0..250 {
        command(&mut board.application, rate(100.0).into());
        board.step();
    }
    assert_eq!(board.outputs.fault, None);
    let error = board.outputs.telemetry.rate - rate(100.0);
    assert!(error.abs() < rate(22.0), "{error}");

    // Less than the monitored rate: no fault, whatever the shaft does.
    let following = |velocity: Rate| {
        let mut application = enabled(BoardParameters::DEFAULT);
        (0..200)
            .find(|_| {
                command(&mut application, velocity.into());
                let outputs = application.control_period(&Samples::at_rest(word(1000)));
                outputs.telemetry.latched.contains(Fault::FollowingError)
            })
            .map(|period| period + 1)
    };
    assert_eq!(following(rate(19.0)), None);
    // 300 ms from the first period whose predecessor commanded the rate.
    assert_eq!(following(rate(20.0)), Some(76));
    assert_eq!(following(rate(-200.0)), Some(76));
}

#[test]
fn a_rate_grows_stale_as_an_angle_does() {
    let mut application = enabled(BoardParameters::DEFAULT);
    command(&mut application, rate(1.0).into());
    let stale = (1..50).find(|_| {
        let outputs = application.control_period(&Samples::at_rest(word(1000)));
        outputs.fault == Some(Fault::CommandTimeout)
    });
    assert_eq!(stale, Some(26));
}

/// A shaft at 8 counts a period, and then a step after missed periods in which it turns as fast,
/// and this number of counts further: telemetry before and after it.
fn after_missed_periods(missed: u8, further: u16) -> (Telemetry, Telemetry) {
    // The estimate is the raw rate.
    let mut parameters = with_gains(ControlParameters {
        rate_filter: 1.0,
        ..ControlParameters::DEFAULT
    });
    parameters.timing.overruns = 250;
    // 8 counts a period are 175.78 deg/s, 12 are 263.67 deg/s.
    parameters.encoder.greatest_rate_deg_s = 200;
    let mut application = Configured::new(parameters);
    let turning = |count| {
        let mut samples = Samples::at_rest(word(count));
        turn(&mut samples, 175.78);
        samples
    };
    let mut count = 1000;
    for _ in 0..10 {
        count += 8;
        application.control_period(&turning(count));
    }
    let before = *application.telemetry();
    let samples = Samples {
        missed_periods: missed,
        ..turning(count + 8 * (u16::from(missed) + 1) + further)
    };
    (before, application.control_period(&samples).telemetry)
}

#[test]
fn protection_and_estimate_agree_after_any_number_of_missed_periods() {
    // Within half a turn: 8 counts a period are 2008 counts after 250 missed ones.
    for missed in [0, 1, 8, 9, 50, 250] {
        let (before, after) = after_missed_periods(missed, 0);
        // The protection accepts the count, and the estimate divides by all periods.
        assert_eq!(before.rate.to_f64(), 8.0 * 11_250.0 / 512.0);
        assert_eq!(after.rate, before.rate, "{missed} missed");
        let travelled = (after.angle - before.angle).to_f64();
        assert_eq!(
            travelled,
            8.0 * 45.0 / 512.0 * f64::from(u16::from(missed) + 1)
        );
    }
    for missed in [0, 1, 8, 9, 50] {
        // Beyond 1.9 deg, 45 % of the way, and the offset of the back-EMF.
        let further = 22 + 4 * (u16::from(missed) + 1);
        let (before, after) = after_missed_periods(missed, further);
        // The protection rejects the count, and the estimate does not see it.
        assert_eq!((after.rate, after.angle), (before.rate, before.angle));
    }
}
