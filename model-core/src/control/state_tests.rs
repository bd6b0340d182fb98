//! What the state keeps and what it drops between steps, and the limits at their ends.

use super::{
    cascade::{CascadeState, Coefficients},
    encoder_word::EncoderCount,
    parameters::ControlParameters,
    units::{Angle, Percent, Rate, angle, percent, rate, round},
};

fn coefficients(change: impl FnOnce(&mut ControlParameters)) -> Coefficients {
    let mut parameters = ControlParameters::default();
    change(&mut parameters);
    Coefficients::try_new(&parameters).expect("parameters within their ranges")
}

fn defaults() -> Coefficients {
    coefficients(|_| ())
}

/// A state that has seen this count.
fn at(count: u16) -> CascadeState {
    let mut state = CascadeState::default();
    state.observe(&defaults(), Some(EncoderCount::new(count)));
    state
}

#[test]
fn only_zero_and_direction_of_the_encoder_are_its_mounting() {
    let zero = coefficients(|p| p.encoder_zero_deg = 10.0);
    let reversed = coefficients(|p| p.encoder_direction = -1.0);
    let stronger = coefficients(|p| p.position_gain = 9.0);
    assert!(defaults().has_mounting_of(&stronger));
    assert!(!defaults().has_mounting_of(&zero));
    assert!(!defaults().has_mounting_of(&reversed));
}

#[test]
fn equal_limits_of_position_are_taken() {
    let held = coefficients(|p| (p.position_min_deg, p.position_max_deg) = (5.0, 5.0));
    assert_eq!(held.reachable(angle(90.0)), angle(5.0));
    assert_eq!(held.reachable(angle(-90.0)), angle(5.0));
}

#[test]
fn missed_periods_are_part_of_the_next_difference() {
    let mut state = at(0);
    assert!(state.shaft().is_known() && !CascadeState::default().shaft().is_known());
    state.miss(3);
    assert_eq!(state.shaft().missed(), 3);
    // Sixteen counts in four periods, of which the filter takes all.
    let gains = coefficients(|p| p.rate_filter = 1.0);
    state.observe(&gains, Some(EncoderCount::new(16)));
    assert_eq!(state.rate(), rate(4.0 * 45.0 / 512.0 / 0.004));
    assert_eq!(state.shaft().missed(), 0);
}

#[test]
fn a_release_empties_the_integrator_and_keeps_the_angle() {
    let mut state = at(100);
    for _ in 0..50 {
        state.regulate(&defaults(), angle(9.0));
    }
    let mut fresh = at(100);
    let expected = fresh.regulate(&defaults(), angle(9.0));
    assert_ne!(state.regulate(&defaults(), angle(9.0)), expected);
    state.release();
    assert_eq!(state.angle(), fresh.angle());
    assert_eq!(state.regulate(&defaults(), angle(9.0)), expected);
}

#[test]
fn a_deceleration_obeys_no_limit_but_the_widest_and_takes_its_sign() {
    let narrow = coefficients(|p| {
        (p.position_min_deg, p.position_max_deg) = (-1.0, 1.0);
        (
            p.rate_command_limit_up_deg_s,
            p.rate_command_limit_down_deg_s,
        ) = (10.0, 10.0);
    });
    let step = at(100).decelerate(&narrow, rate(-50.0));
    assert_eq!(step.rate_command, rate(-50.0));
    assert!(!step.limits.rate && step.duty < Percent::ZERO);
    let step = at(100).decelerate(&narrow, Rate::MAX);
    assert_eq!(step.rate_command, Rate::from_int(1 << 17));
    assert!(step.limits.rate);
}

#[test]
fn without_a_gain_a_rate_stops_at_a_limit_from_either_side_and_leaves_it() {
    let gains = coefficients(|p| {
        p.position_gain = 0.0;
        (p.position_min_deg, p.position_max_deg) = (-9.0, 9.0);
    });
    // 9 deg are 102.4 counts.
    for (counts, command, expected) in [
        (102, 40.0, 40.0),
        (103, 40.0, 0.0),
        (103, -40.0, -40.0),
        (4096 - 102, -40.0, -40.0),
        (4096 - 103, -40.0, 0.0),
        (4096 - 103, 40.0, 40.0),
    ] {
        let step = at(counts).regulate(&gains, rate(command));
        assert_eq!(step.rate_command, rate(expected), "{command} at {counts}");
        assert_eq!(step.limits.position, command != expected);
    }
    // At the limit itself.
    let at_zero = coefficients(|p| {
        p.position_gain = 0.0;
        (p.position_min_deg, p.position_max_deg) = (0.0, 0.0);
    });
    for command in [-40.0, 40.0] {
        let step = at(0).regulate(&at_zero, rate(command));
        assert_eq!(step.rate_command, Rate::ZERO);
    }
}

#[test]
fn a_value_is_limited_beyond_its_limit_and_not_at_it() {
    let limit = percent(5.0);
    for (value, expected) in [
        (5.0, 5.0),
        (5.5, 5.0),
        (-5.0, -5.0),
        (-5.5, -5.0),
        (1.0, 1.0),
    ] {
        assert_eq!(percent(value).limited(limit), percent(expected), "{value}");
    }
    let step = at(0).regulate(
        &coefficients(|p| p.rate_command_limit_up_deg_s = 8.0),
        angle(1.0),
    );
    assert_eq!(step.rate_command, rate(8.0));
    assert!(
        !step.limits.rate,
        "a rate at its limit is not changed by it"
    );
}

#[test]
fn a_narrowed_duty_limit_takes_precedence_over_the_slew() {
    let wide = coefficients(|p| p.duty_slew_pct_s = 250.0);
    let narrow = coefficients(|p| (p.duty_slew_pct_s, p.duty_limit_pct) = (250.0, 20.0));
    let mut state = at(0);
    for _ in 0..60 {
        state.regulate(&wide, angle(90.0));
    }
    // From 60 % with 1 % a period: the limit of 20 % decides, and the slew changed nothing of it.
    let step = state.regulate(&narrow, angle(90.0));
    assert_eq!(step.duty, percent(20.0));
    assert!(step.limits.duty && !step.limits.slew);
    // Towards the other end the limit of 20 % decides again, and the slew changed -20 % to it.
    let mut state = at(0);
    for _ in 0..60 {
        state.regulate(&wide, angle(90.0));
    }
    let step = state.regulate(&narrow, angle(-90.0));
    assert_eq!(step.duty, percent(20.0));
    assert!(step.limits.duty && step.limits.slew);
}

#[test]
fn the_angle_of_the_encoders_zero_has_its_sign() {
    for (written, read) in [(-90.0, -90.0), (90.0, 90.0), (-180.0, -180.0), (0.0, 0.0)] {
        let gains = coefficients(|p| p.encoder_zero_deg = written);
        assert_eq!(gains.get(12), Some(read as f32));
    }
    assert_eq!(at(2048).angle(), Angle::from_int(-180));
    assert_eq!(at(2047).angle(), angle(2047.0 * 45.0 / 512.0));
}

#[test]
fn a_rate_at_the_lower_limit_is_not_changed_by_it() {
    let gains = coefficients(|p| p.rate_command_limit_down_deg_s = 8.0);
    let step = at(0).regulate(&gains, angle(-1.0));
    assert_eq!((step.rate_command, step.limits.rate), (rate(-8.0), false));
    let step = at(0).regulate(&gains, angle(-1.5));
    assert_eq!((step.rate_command, step.limits.rate), (rate(-8.0), true));
}

#[test]
fn the_angle_ends_after_91_turns_either_way() {
    for (step, end) in [(2000, 32_768), (4096 - 2000, -32_768)] {
        let mut state = CascadeState::default();
        let mut count = 0;
        for _ in 0..200 {
            state.observe(&defaults(), Some(EncoderCount::new(count)));
            count = (count + step) % 4096;
        }
        assert_eq!(state.angle(), Angle::from_int(end));
    }
}

#[test]
fn whole_numbers_are_not_rounded() {
    for whole in [(1_u64 << 52) as f64 + 1.0, (1_u64 << 53) as f64] {
        assert_eq!(round(whole), whole);
        assert_eq!(round(-whole), -whole);
    }
    assert_eq!((round(2.5), round(-2.5)), (3.0, -3.0));
}
