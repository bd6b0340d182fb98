use super::*;
use crate::analysis::referee::Board;
use proptest::prelude::*;

/// A request for a position loop on the paper's motor.
fn position(bandwidth_hz: f64, phase_margin_deg: f64) -> TuneRequest {
    TuneRequest {
        goal: Goal::Position(PositionLoop {
            bandwidth_hz,
            phase_margin_deg,
        }),
        ..TuneRequest::default()
    }
}

/// A request for a rate loop on the paper's motor.
fn inner(inner_bandwidth_rad_s: f64, position_share: f64) -> TuneRequest {
    TuneRequest {
        goal: Goal::Inner(InnerLoop {
            inner_bandwidth_rad_s,
            position_share,
        }),
        ..TuneRequest::default()
    }
}

/// Whether the tuned board settles in a time-domain simulation with this factor on its gain.
fn settles(request: &TuneRequest, tuning: &Tuning, gain: f64) -> bool {
    let board = Board {
        motor: request.motor,
        control: tuning.control,
        timing: request.timing,
        linear: true,
        gain,
    };
    board.settles(10.0)
}

/// Asserts that the loop is stable 1 % below its gain margin and unstable 1 % above it.
fn assert_gain_margin_in_time(request: &TuneRequest, tuning: &Tuning) {
    let limit = 10.0_f64.powf(tuning.margins.gain_db.unwrap().value / 20.0);
    assert!(settles(request, tuning, 1.0));
    assert!(settles(request, tuning, 0.99 * limit));
    assert!(!settles(request, tuning, 1.01 * limit));
}

#[test]
fn the_papers_motor_and_bandwidth_give_the_default_gains() {
    let request = TuneRequest::default();
    let tuning = tune(&request).unwrap();
    let default = ControlParameters::default();
    let gains = |c: &ControlParameters| {
        [
            c.position_gain,
            c.proportional_gain,
            c.integral_gain,
            c.anti_windup_gain,
        ]
    };
    for (found, expected) in gains(&tuning.control).iter().zip(gains(&default)) {
        assert!((found / expected - 1.0).abs() < 1e-12);
    }
    assert_eq!(tuning.warnings, []);
    assert_gain_margin_in_time(&request, &tuning);
}

#[test]
fn one_count_changes_the_duty_by_the_filtered_difference() {
    let tuning = tune(&TuneRequest::default()).unwrap();
    // 1.318 * 0.0879 * (8 + 0.4/0.004)
    assert!((tuning.duty_jump_pct - 12.51).abs() < 0.01);

    let mut unfiltered = TuneRequest::default();
    unfiltered.control.rate_filter = 1.0;
    let tuning = tune(&unfiltered).unwrap();
    // The 29 % of the rate alone, and 0.9 % of the position.
    assert!((tuning.duty_jump_pct - 29.89).abs() < 0.01);
    assert_eq!(
        tuning.warnings[0].to_string(),
        "one encoder count moves the duty by 29.9 %, expected at most 20 %: filter the rate more \
         or lower the bandwidth"
    );
}

#[test]
fn the_default_loop_is_recovered_from_its_bandwidth_and_phase_margin() {
    let default = tune(&TuneRequest::default()).unwrap();
    let bandwidth_hz = default.bandwidth_hz.unwrap();
    let phase_margin_deg = default.margins.phase_deg.unwrap().value;
    let found = tune(&position(bandwidth_hz, phase_margin_deg)).unwrap();
    assert!((found.bandwidth_hz.unwrap() / bandwidth_hz - 1.0).abs() < 1e-6);
    let phase = found.margins.phase_deg.unwrap().value;
    // Where the phase margin is constant over the shares, other gains may meet the goal: the
    // smallest are selected, so the proportional gain is at most that of the default.
    assert!((phase - phase_margin_deg).abs() < 1e-6, "{found:?}");
    let ratio = found.control.proportional_gain / default.control.proportional_gain;
    assert!(ratio < 1.0 + 1e-6, "{ratio}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]
    #[test]
    fn a_reachable_goal_is_met_in_a_time_domain_simulation_of_the_board(
        // At 3 Hz this board has a phase margin of 50.4 deg, at lower bandwidths more.
        bandwidth_hz in 0.5..2.5f64,
        phase_margin_deg in 40.0..50.0f64,
        motor_time_constant_s in 0.05..0.3f64,
    ) {
        let mut request = position(bandwidth_hz, phase_margin_deg);
        request.motor.motor_time_constant_s = motor_time_constant_s;
        let tuning = tune(&request).unwrap();
        let found_hz = tuning.bandwidth_hz.unwrap();
        prop_assert!((found_hz / bandwidth_hz - 1.0).abs() < 1e-6);
        prop_assert!(tuning.margins.phase_deg.unwrap().value >= phase_margin_deg);
        assert_gain_margin_in_time(&request, &tuning);
    }

    #[test]
    fn no_request_causes_a_panic(
        numbers in prop::array::uniform7(prop_oneof![any::<f64>(), 1e-3..10.0f64, 1e-4..0.1f64]),
    ) {
        let [bandwidth, phase, gain, tau, period, delay, filter] = numbers;
        for mut request in [position(bandwidth, phase), inner(bandwidth, phase)] {
            request.motor = Motor { motor_gain: gain, motor_time_constant_s: tau };
            request.timing = Timing { control_period_s: period, duty_delay_s: delay };
            request.control.rate_filter = filter;
            let _ = tune(&request);
        }
    }
}

#[test]
fn an_unreachable_bandwidth_is_rejected_with_the_maximum() {
    let error = tune(&position(100.0, 45.0)).unwrap_err();
    let TuneError::BandwidthOutOfReach { maximum_hz, .. } = error else {
        panic!("{error}");
    };
    assert!(
        error
            .to_string()
            .starts_with("bandwidth_hz is 100, expected at most ")
    );
    assert!(tune(&position(0.999 * maximum_hz, 45.0)).is_ok());
    assert!(tune(&position(1.001 * maximum_hz, 45.0)).is_err());
}

#[test]
fn a_resonance_above_a_notch_does_not_count_as_bandwidth() {
    // During the search the gain rises above -3 dB at 20 Hz before it does at 5 Hz.
    let tuning = tune(&position(20.0, 45.0)).unwrap();
    assert!(tuning.bandwidth_hz.unwrap() >= 19.99, "{tuning:?}");
}

#[test]
fn an_unreachable_phase_margin_gives_a_warning() {
    let tuning = tune(&position(6.0, 80.0)).unwrap();
    assert!((tuning.bandwidth_hz.unwrap() - 6.0).abs() < 1e-5);
    let text = tuning.warnings[0].to_string();
    assert!(text.starts_with("the phase margin is "), "{text}");
    assert!(text.ends_with("expected at least 80 deg"), "{text}");
}

#[test]
fn an_inner_loop_too_fast_for_the_board_gives_a_warning() {
    let mut request = inner(400.0, 0.25);
    let tuning = tune(&request).unwrap();
    assert!(!tuning.margins.stable);
    assert_eq!(
        tuning.warnings[0].to_string(),
        "the sampled loop is unstable"
    );
    assert!(!settles(&request, &tuning, 1.0));
    // A third of it is stable, with less than the customary margins.
    request.goal = inner(130.0, 0.25).goal;
    let tuning = tune(&request).unwrap();
    assert!(tuning.margins.stable && settles(&request, &tuning, 1.0));
    assert!(
        tuning
            .warnings
            .iter()
            .any(|w| matches!(w, Warning::PhaseMargin { .. }))
    );
    assert!(
        tuning
            .warnings
            .iter()
            .any(|w| matches!(w, Warning::GainMargin { .. }))
    );
}

#[test]
fn the_error_of_an_invalid_given_or_computed_parameter_names_it() {
    let text = |request: &TuneRequest| tune(request).unwrap_err().to_string();
    assert_eq!(
        text(&inner(f64::NAN, 0.25)),
        "inner_bandwidth_rad_s is NaN, expected a number from 0.001 to 10000 rad/s"
    );
    assert_eq!(
        text(&position(-1.0, 45.0)),
        "bandwidth_hz is -1, expected a number from 0.01 to 1000 Hz"
    );
    // 5000/2.836 = 1763 %/deg
    let found = text(&inner(5000.0, 0.05));
    assert!(found.contains("expected a number from 0 to "), "{found}");
}
