//! Tests over many runs.

use super::*;

/// How many of the 95 % intervals of all parameters contain the true value, over 200 runs.
fn share_inside(model: &str, kind: ModelKind, truth: Truth) -> f64 {
    let clean = simulated(kind, "pulse", 80, &[]);
    let options = Options {
        starts: 1,
        ..Default::default()
    };
    let (mut inside, mut all) = (0, 0);
    for seed in 0..200 {
        let problem = problem(model, vec![noisy(clean.clone(), 1000 + seed)]);
        let fit = fit(&problem, &options, &Quiet).expect("a fit");
        for (name, truth) in truth {
            let e = fit.estimate(name).expect("an estimate");
            inside += usize::from((e.value - truth).abs() < 1.96 * e.standard_error);
            all += 1;
        }
    }
    inside as f64 / all as f64
}

#[test]
fn nineteen_of_twenty_intervals_contain_the_true_value_for_each_model() {
    for (model, kind, truth) in truths() {
        let share = share_inside(model, kind, truth);
        assert!((0.92..0.97).contains(&share), "{model}: {share}");
    }
}

// Forty starts for each model and input: the example `start_table`.
#[test]
fn starts_from_a_quarter_to_four_times_the_true_value_reach_the_optimum() {
    for (model, kind, truth) in truths() {
        for input in ["pulse", "variable-step", "3-2-1-1"] {
            let run = noisy(simulated(kind, input, 80, &[]), 1);
            let mut problem = problem(model, vec![run]);
            let best = fitted(&problem).cost;
            for start in 0..4 {
                let mut noise = Noise::new(start, 77);
                for (name, truth) in truth.iter().filter(|(_, truth)| *truth != 0.0) {
                    let factor = 4.0_f64.powf(noise.gaussian(0.6).clamp(-1.0, 1.0));
                    problem
                        .start(name, truth * factor)
                        .expect("within its range");
                }
                let options = Options {
                    starts: 4,
                    seed: start,
                    ..Default::default()
                };
                let fit = fit(&problem, &options, &Quiet).expect("a fit");
                let excess = fit.cost / best - 1.0;
                // 1e-6 of the cost is a twentieth of a standard error.
                assert!(excess < 1e-6, "{model} {input} start {start}: {excess}");
            }
        }
    }
}
