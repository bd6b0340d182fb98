//! Correlations against their theory: closed forms and false-alarm rates.

use super::*;

const STEP_S: f64 = 0.004;

fn time_s(samples: usize) -> Vec<f64> {
    (0..samples).map(|i| i as f64 * STEP_S).collect()
}

fn noise(samples: usize, seed: u64) -> Vec<f64> {
    super::super::tests::white(samples, seed)
}

/// First-order filtered noise: its autocorrelation is `a^lag`.
fn coloured(samples: usize, a: f64, seed: u64) -> Vec<f64> {
    let mut state = 0.0;
    let filter = |w: f64| {
        state = a * state + w;
        state
    };
    noise(samples, seed).into_iter().map(filter).collect()
}

#[test]
fn white_residuals_pass_at_the_rate_of_the_significance_level() {
    let runs = 300;
    let alarms = (0..runs).filter(|&seed| {
        let (e, u) = (noise(1000, seed), coloured(1000, 0.9, seed + 10_000));
        let correlations = Correlations::of(&time_s(1000), &e, &u).expect("noise");
        !correlations.whiteness.is_white()
    });
    // 3 of 300 are expected; ten have a probability below 0.001.
    assert!(alarms.count() < 10);
}

#[test]
fn the_band_of_the_cross_correlation_holds_for_two_coloured_signals() {
    let (mut inside, mut all) = (0, 0);
    for seed in 0..100 {
        let (e, u) = (
            coloured(2000, 0.8, seed),
            coloured(2000, 0.9, seed + 10_000),
        );
        let c = Correlations::of(&time_s(2000), &e, &u).expect("noise");
        // Adjacent lags are correlated: every 50th lag is nearly an independent trial.
        for (value, band) in c.cross.iter().zip(&c.cross_band).step_by(50) {
            inside += usize::from(value.abs() <= *band);
            all += 1;
        }
    }
    let share = inside as f64 / all as f64;
    // Expected 0.95; white-noise bands would hold 0.66 of them.
    assert!((0.92..0.98).contains(&share), "{share}");
}

#[test]
fn coloured_residuals_have_the_autocorrelation_of_their_filter_and_fewer_samples() {
    let e = coloured(50_000, 0.9, 1);
    let correlations = Correlations::of(&time_s(50_000), &e, &e).expect("noise");
    for lag in 0..10 {
        // Five standard errors of an autocorrelation of 50 000 samples of that colour.
        assert!((correlations.auto[lag] - 0.9_f64.powi(lag as i32)).abs() < 0.07);
    }
    assert!(!correlations.whiteness.is_white());
    // (1 + a)/(1 - a) = 19.
    let length = 50_000.0 / correlations.effective_samples;
    assert!((15.0..23.0).contains(&length), "{length}");
}

#[test]
fn a_residual_that_follows_the_input_is_correlated_at_its_lag() {
    let u = noise(1000, 3);
    let own = noise(1000, 4);
    let e: Vec<f64> = (0..1000)
        .map(|i| own[i] + if i >= 7 { 0.5 * u[i - 7] } else { 0.0 })
        .collect();
    let c = Correlations::of(&time_s(1000), &e, &u).expect("noise");
    let peak = (0..c.cross.len())
        .max_by(|&a, &b| c.cross[a].total_cmp(&c.cross[b]))
        .expect("lags");
    assert!((c.cross_lag_s[peak] - 7.0 * STEP_S).abs() < 1e-9);
    assert!(c.is_correlated_with_input());
    let other = Correlations::of(&time_s(1000), &own, &u).expect("noise");
    assert!(!other.is_correlated_with_input());
}

#[test]
fn uneven_samples_give_the_same_correlation_as_even_ones() {
    let all = coloured(20_000, 0.9, 5);
    let kept: Vec<usize> = (0..20_000).filter(|i| i % 7 != 3 && i % 11 != 5).collect();
    let time: Vec<f64> = kept.iter().map(|&i| i as f64 * STEP_S).collect();
    let e: Vec<f64> = kept.iter().map(|&i| all[i]).collect();
    let c = Correlations::of(&time, &e, &e).expect("noise");
    for lag in 0..10 {
        assert!((c.auto[lag] - 0.9_f64.powi(lag as i32)).abs() < 0.1);
    }
}

#[test]
fn a_recording_without_information_has_no_correlations() {
    assert_eq!(Correlations::of(&[], &[], &[]), None);
    assert_eq!(
        Correlations::of(&[0.0, 1.0], &[f64::NAN; 2], &[0.0, 1.0]),
        None
    );
    assert_eq!(Correlations::of(&time_s(9), &[1.0; 9], &[0.0; 9]), None);
    let constant_input = Correlations::of(&time_s(9), &noise(9, 1), &[5.0; 9]);
    assert!(constant_input.is_some_and(|c| c.cross.is_empty()));
}
