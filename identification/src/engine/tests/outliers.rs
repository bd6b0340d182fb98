//! Bad readings that are not left out before the fit.

use super::*;
use crate::loss::{Loss, LossChoice};

/// Fits to the same recording with each loss.
fn with_loss(problem: &Problem, loss: LossChoice) -> Fit {
    let options = Options {
        loss,
        ..Default::default()
    };
    fit(problem, &options, &Quiet).expect("a fit")
}

fn assert_covered(fit: &Fit, truth: &[(&str, f64)], case: &str) {
    for (name, truth) in truth {
        let e = fit.estimate(name).expect("an estimate");
        // Beyond four standard errors once in 16,000.
        let error = e.standard_error.max(e.standard_error_coloured);
        assert!((e.value - truth).abs() < 4.0 * error, "{case} {e:?}");
    }
}

/// A pulse with zero readings while the angle is at its maximum.
fn with_zero_readings(seed: u64) -> Recording {
    let mut run = noisy(simulated(ModelKind::BlackBox1, "pulse", 80, &[]), seed);
    let high: Vec<usize> = (0..run.len())
        .filter(|&i| run.angle_deg[i] > 50.0)
        .collect();
    for k in [1, 2, 3] {
        run.angle_deg[high[k * high.len() / 4]] = 0.0;
    }
    run
}

#[test]
fn three_zero_readings_do_not_decide_a_fit() {
    for seed in 0..4 {
        let problem = problem("black-box-1", vec![with_zero_readings(seed)]);
        let fit = with_loss(&problem, LossChoice::Auto);
        assert!(matches!(fit.loss, Loss::Student { scale_deg } if scale_deg < 0.1));
        assert_eq!(fit.experiments[0].outliers.len(), 3);
        assert_covered(&fit, &BLACK_BOX_1, "zero readings");
        let pole = fit.estimate("pole_rad_s").expect("a pole");
        assert!(pole.standard_error < 0.5, "{pole:?}");
    }
}

#[test]
fn least_squares_finds_its_optimum_among_zero_readings() {
    for seed in 0..4 {
        let problem = problem("black-box-1", vec![with_zero_readings(seed)]);
        let usual = with_loss(&problem, LossChoice::Squares);
        let mut bounded = problem.clone();
        bounded.bound("pole_rad_s", 15.0, 60.0).expect("bounds");
        bounded
            .bound("rate_limit_up_deg_s", 100.0, 500.0)
            .expect("bounds");
        bounded
            .bound("rate_limit_down_deg_s", 100.0, 700.0)
            .expect("bounds");
        let near = with_loss(&bounded, LossChoice::Squares);
        assert!(
            usual.cost <= near.cost * (1.0 + 1e-6),
            "{} {}",
            usual.cost,
            near.cost
        );
    }
}

#[test]
fn one_glitch_of_40_deg_does_not_decide_a_fit() {
    let cases = [
        ("black-box-1", ModelKind::BlackBox1, &BLACK_BOX_1[..]),
        ("black-box-2", ModelKind::BlackBox2, &BLACK_BOX_2[..]),
    ];
    for (model, kind, truth) in cases {
        for seed in 0..8 {
            let mut run = noisy(simulated(kind, "pulse", 80, &[]), seed);
            // Everywhere in the pulse, in motion too.
            run.angle_deg[150 + 100 * seed as usize] += 40.0;
            let fit = with_loss(&problem(model, vec![run]), LossChoice::Auto);
            assert!(matches!(fit.loss, Loss::Student { .. }), "{model} {seed}");
            assert_covered(&fit, truth, &format!("{model} {seed}"));
        }
    }
}

#[test]
fn a_model_that_lacks_dynamics_is_still_fitted_by_squares() {
    for input in ["pulse", "variable-step", "3-2-1-1", "prbs"] {
        for every in [80, 400] {
            let run = noisy(simulated(ModelKind::GreyBox, input, every, &[]), 1);
            let fit = with_loss(&problem("black-box-1", vec![run]), LossChoice::Auto);
            assert_eq!(fit.loss, Loss::Squares, "{input} {every}");
        }
    }
}

#[test]
fn a_robust_fit_of_normal_noise_is_the_fit_by_squares_within_its_errors() {
    let run = noisy(simulated(ModelKind::BlackBox1, "pulse", 80, &[]), 1);
    let problem = problem("black-box-1", vec![run]);
    let [squares, robust] =
        [LossChoice::Squares, LossChoice::Robust].map(|loss| with_loss(&problem, loss));
    for (a, b) in squares.estimates.iter().zip(&robust.estimates) {
        if a.standard_error.is_finite() {
            assert!((a.value - b.value).abs() < a.standard_error, "{a:?} {b:?}");
            // The efficiency for normal noise is 0.95.
            let ratio = b.standard_error / a.standard_error;
            assert!((0.95..1.15).contains(&ratio), "{} {ratio}", a.name);
        }
    }
}

#[test]
fn no_recording_without_outliers_calls_for_a_robust_loss() {
    for (model, kind, _) in truths() {
        for input in ["pulse", "variable-step", "sine", "chirp"] {
            for (every, run) in [80, 400].map(|e| (e, simulated(kind, input, e, &[]))) {
                // Without noise, quantised alone, and with noise.
                let mut coarse = run.clone();
                for angle in &mut coarse.angle_deg {
                    *angle = (*angle / 0.088).round() * 0.088;
                }
                for (k, run) in [run.clone(), coarse, noisy(run, 5)].into_iter().enumerate() {
                    let fit = with_loss(&problem(model, vec![run]), LossChoice::Auto);
                    assert_eq!(fit.loss, Loss::Squares, "{model} {input} {every} {k}");
                }
            }
        }
    }
}
