//! The comparison over sequences of counts and back-EMFs.

use super::{motor::BRIDGED, *};
use crate::parameters::ModelSettings;

const PERIODS_PER_S: f64 = CONTROL_RATE_HZ as f64;

#[test]
fn an_encoder_that_flickers_around_gaps_of_the_back_emf_adds_up_to_nothing() {
    let motor = MotorConstants::of(&ModelSettings::DEFAULT);
    // Short gaps, and those after which the travel is not known.
    for hidden in 1..=6 {
        for sign in [1, -1] {
            let mut guard = TravelGuard::default();
            let mut most = 0;
            for period in 0..1000 {
                let at = period % (hidden + 1);
                guard.advance(&motor, (at == 0).then_some(0), 0);
                // Ahead in the gap, and back behind it.
                let travelled = match at {
                    _ if period == 0 => 0,
                    0 => -sign,
                    1 => sign,
                    _ => 0,
                };
                assert!(guard.accept(travelled, 700));
                most = most
                    .max(guard.above)
                    .max(guard.below)
                    .max(guard.drift.abs());
            }
            assert_eq!(most, 0, "{hidden}");
        }
    }
}

/// A guard whose encoder jumps by these counts in the first period of a gap and is compared
/// behind it, so many times.
fn after_a_jump(jump: i32, hidden: usize, repeated: usize) -> TravelGuard {
    let motor = MotorConstants::of(&ModelSettings::DEFAULT);
    let mut guard = TravelGuard::default();
    guard.advance(&motor, Some(0), 0);
    assert!(guard.accept(0, 700));
    for _ in 0..repeated {
        for period in 0..hidden {
            guard.advance(&motor, None, 0);
            assert!(guard.accept(if period == 0 { jump } else { 0 }, 700));
        }
        guard.advance(&motor, Some(0), 0);
        assert!(guard.accept(0, 700));
    }
    guard
}

#[test]
fn a_magnet_that_slips_in_a_short_gap_is_implausible_with_the_next_back_emf() {
    for sign in [1, -1] {
        for hidden in 1..BRIDGED as usize {
            // 2.2 deg, and 5 deg/s for four periods, are 26 counts.
            assert!(!after_a_jump(27 * sign, hidden, 1).check().is_empty());
            assert!(after_a_jump(21 * sign, hidden, 1).check().is_empty());
            assert!(!after_a_jump(21 * sign, hidden, 2).check().is_empty());
        }
        // The travel of a longer one is not known.
        let guard = after_a_jump(27 * sign, BRIDGED as usize, 1);
        assert!(guard.check().is_empty());
    }
}

#[test]
fn the_window_of_a_count_does_not_grow_with_the_length_of_a_gap() {
    let motor = MotorConstants::of(&ModelSettings::DEFAULT);
    let mut guard = TravelGuard::default();
    for period in 0..40 {
        guard.advance(&motor, (period == 0).then_some(0), 0);
        assert!(guard.accept(0, 700));
    }
    guard.advance(&motor, None, 0);
    // 700 deg/s for a period, 1.9 deg and 5 deg/s: 53 counts.
    assert!(!guard.accept(54, 700));
    assert!(guard.accept(53, 700));
}

#[test]
fn an_offset_of_the_back_emf_in_many_gaps_is_no_drift() {
    let motor = MotorConstants::of(&ModelSettings::DEFAULT);
    let mut guard = TravelGuard {
        offset: LegOffset::NONE,
        ..TravelGuard::default()
    };
    // 18 mV are 0.9 deg/s, and three of four scans have no back-EMF.
    for period in 0..20_000 {
        guard.advance(&motor, (period % 4 == 0).then_some(18), 0);
        assert!(guard.accept(0, 700));
        assert!(guard.check().is_empty(), "{period}");
    }
}

#[test]
fn legs_that_settle_behind_a_gap_are_not_compared_until_two_of_them_agree() {
    let motor = MotorConstants::of(&ModelSettings::DEFAULT);
    // A stop of a motor of 70 % of the constant: the current ends shortly before the first
    // scans. Rates by the legs, deg/s, and counts of the encoder.
    let scans = [288, 159, 111, 78, 57, 41, 31, 23, 17, 10, 6, 0].into_iter();
    let counts = [2, 4, 3, 1, 3, 1, 2, 1, 1, 1, 0, 0];
    for sign in [1, -1] {
        let mut guard = TravelGuard {
            offset: LegOffset::NONE,
            ..TravelGuard::default()
        };
        guard.advance(&motor, Some(sign * 60 * 20), 0);
        assert!(guard.accept(0, 700));
        for _ in 0..6 {
            guard.advance(&motor, None, 0);
            assert!(guard.accept(5 * sign, 700));
        }
        let mut most = 0;
        for (deg_s, count) in scans.clone().zip(counts) {
            guard.advance(&motor, Some(sign * deg_s * 20), 0);
            assert!(guard.accept(sign * count, 700));
            most = most.max(guard.above).max(guard.below);
        }
        // The last scan that has not settled is 33 deg/s off: half of it, for a period, is 0.07
        // deg, and there are two counts of rounding.
        assert!(most < 2 * COUNT + 70 * MDEG, "{} mdeg", most / MDEG);
    }
}

/// Seconds until it is implausible that the encoder turns at the one rate and the motor at the
/// other, deg/s, at most 20 s; the back-EMF has this offset, mV, before and after the start.
fn detected_s(encoder_deg_s: f64, motor_deg_s: f64, offset_mv: f64) -> Option<f64> {
    let motor = MotorConstants::of(&ModelSettings::DEFAULT);
    let mut guard = TravelGuard::default();
    for _ in 0..100 {
        let back_emf_mv = Some(offset_mv as i32);
        guard.advance(&motor, back_emf_mv, 0);
        guard.accept(0, 700);
        guard.learn(false, Some(0), back_emf_mv);
    }
    let mut last = 0;
    for period in 1..=(20.0 * PERIODS_PER_S) as i32 {
        let seconds = f64::from(period) / PERIODS_PER_S;
        let counts = (encoder_deg_s * seconds * 4096.0 / 360.0).round() as i32;
        let back_emf_mv = (motor_deg_s * 20.218 + offset_mv).round() as i32;
        guard.advance(&motor, Some(back_emf_mv), 0);
        guard.accept(counts - last, 700);
        last = counts;
        if !guard.check().is_empty() {
            return Some(seconds);
        }
    }
    None
}

#[test]
fn a_drift_is_detected_after_the_limit_over_what_exceeds_the_allowance() {
    for sign in [1.0, -1.0] {
        for drift in [2.0, 5.0, 20.0, 100.0] {
            // The motor stands, or the loop turns it against the drift.
            for offset_mv in [0.0, 80.0, -80.0] {
                let found = detected_s(sign * drift, 0.0, offset_mv).expect("detected");
                let expected = f64::from(LIMIT_MDEG) * 1e-3 / (drift - 1.0);
                // A period, a count of the encoder at its edge, and the rounding of the offset
                // to a mV, 0.05 deg/s.
                let tolerance = 0.004 + (0.088 + 0.05 * expected) / (drift - 1.0);
                assert!((found - expected).abs() <= tolerance, "{drift}: {found}");
            }
        }
    }
}

#[test]
fn a_constant_of_the_back_emf_within_30_percent_is_plausible_at_every_rate() {
    for rate in [-350.0, -40.0, 1.0, 40.0, 350.0] {
        for constant in [0.7, 1.0, 1.3] {
            assert_eq!(
                detected_s(rate, rate * constant, 0.0),
                None,
                "{rate}, {constant}"
            );
        }
    }
    // Half of the travel is missing.
    assert!(detected_s(50.0, 100.0, 0.0).is_some());
}

#[test]
fn the_single_counts_of_a_slow_encoder_add_up_to_nothing_at_any_constant() {
    let motor = MotorConstants::of(&ModelSettings::DEFAULT);
    for (constant, rate) in [(0.7, 34.0), (0.7, -34.0), (1.3, 24.0), (1.3, -45.0)] {
        let mut guard = TravelGuard {
            offset: LegOffset::NONE,
            ..TravelGuard::default()
        };
        let (mut last, mut most) = (0, 0);
        for period in 1..=5000 {
            let degrees = rate * f64::from(period) / PERIODS_PER_S;
            let counts = (degrees * 4096.0 / 360.0).round() as i32;
            let back_emf_mv = (rate * constant * 20.218).round() as i32;
            guard.advance(&motor, Some(back_emf_mv), 0);
            guard.accept(counts - last, 700);
            last = counts;
            most = most.max(guard.above).max(guard.below);
        }
        // Three counts: two of rounding, and half of one in the first period.
        assert!(
            most <= 3 * COUNT,
            "{constant}, {rate}: {} mdeg",
            most / MDEG
        );
    }
}

/// Seconds until it is implausible that the encoder turns at a rate, deg/s, of the time, s, and
/// of the motor's rate. The motor moves to and fro with 90 deg/s at 0.5 Hz, 57 deg from end to
/// end, for 30 s, and has this constant of the back-EMF.
fn detected_to_and_fro_s(constant: f64, encoder: impl Fn(f64, f64) -> f64) -> Option<f64> {
    let motor = MotorConstants::of(&ModelSettings::DEFAULT);
    let mut guard = TravelGuard {
        offset: LegOffset::NONE,
        ..TravelGuard::default()
    };
    let (mut encoder_deg, mut last) = (0.0, 0);
    (1..=7500).map(|n| f64::from(n) / PERIODS_PER_S).find(|s| {
        let rate = |s: f64| 90.0 * (core::f64::consts::PI * s).sin();
        let back_emf_mv = (rate(*s) * constant * 20.218).round() as i32;
        guard.advance(&motor, Some(back_emf_mv), 0);
        let mean = (rate(*s) + rate(s - 0.004)) / 2.0;
        encoder_deg += encoder(*s, mean) / PERIODS_PER_S;
        let counts = (encoder_deg * 4096.0 / 360.0).round() as i32;
        guard.accept(counts - last, 700);
        last = counts;
        !guard.check().is_empty()
    })
}

#[test]
fn a_drift_is_detected_in_a_motion_to_and_fro_and_an_error_of_the_constant_is_not() {
    // The encoder has a scale, and a drift in deg/s.
    let detected_s =
        |scale: f64, drift: f64| detected_to_and_fro_s(1.0, |_, motor| motor * scale + drift);
    for scale in [0.77, 1.0, 1.43] {
        assert_eq!(detected_s(scale, 0.0), None, "{scale}");
        for drift in [-20.0, -5.0, 5.0, 20.0] {
            // 4 deg beyond the tolerance of the travel, which returns to zero every 2 s.
            let found = detected_s(scale, drift).expect("a drift");
            assert!(found < 2.5, "{scale} {drift}: {found} s");
        }
    }
    assert_eq!(detected_s(1.0, 1.0), None);
}

#[test]
fn a_scale_that_changes_once_the_constant_is_learned_is_detected() {
    // The scale after 10 s.
    let detected_s = |constant: f64, scale: f64| {
        let shown = |s: f64, motor: f64| motor * if s < 10.0 { 1.0 } else { scale };
        detected_to_and_fro_s(constant, shown).map(|s| s - 10.0)
    };
    for constant in [0.7, 1.0, 1.3] {
        for scale in [0.88, 1.0, 1.12] {
            assert_eq!(detected_s(constant, scale), None, "{constant}, {scale}");
        }
        for scale in [0.7, 1.36] {
            // 2.2 deg are the excess over 22 % of 27 deg, a way that takes 0.5 s.
            let found = detected_s(constant, scale).expect("detected");
            assert!(found < 0.6, "{constant}, {scale}: {found} s");
        }
    }
}

#[test]
fn a_single_count_is_rejected_beyond_the_window_and_while_the_motor_is_blind_beyond_its_rate() {
    let motor = MotorConstants::of(&ModelSettings::DEFAULT);
    let is_valid = |travelled, back_emf: &[Option<i32>]| {
        let mut guard = TravelGuard::default();
        guard.advance(&motor, Some(0), 0);
        guard.accept(0, 700);
        for mv in back_emf {
            guard.advance(&motor, *mv, 0);
        }
        guard.accept(travelled, 700)
    };
    for sign in [1, -1] {
        // 1.9 deg and 5 deg/s for a period are 21.8 counts.
        assert!(is_valid(21 * sign, &[Some(0)]));
        assert!(!is_valid(22 * sign, &[Some(0)]));
        // 700 deg/s for a period are 31.9 counts, and 5 deg/s another 0.2.
        assert!(is_valid(53 * sign, &[Some(0), None]));
        assert!(!is_valid(54 * sign, &[Some(0), None]));
    }
}
