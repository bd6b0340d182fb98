//! A model never fits worse than a nested one, and a stopped search ends.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::*;
use crate::levenberg::Termination;

#[test]
fn black_box_2_fits_no_worse_than_black_box_1_which_it_contains() {
    // A chirp of 20 s costs as much as all the others.
    for (input, seeds) in [
        ("pulse", 5),
        ("variable-step", 5),
        ("3-2-1-1", 5),
        ("chirp", 1),
    ] {
        for seed in 0..seeds {
            let run = noisy(simulated(ModelKind::BlackBox1, input, 80, &[]), seed);
            let simple = fitted(&problem("black-box-1", vec![run.clone()]));
            for name in ["black-box-2", "black-box-2-oscillator"] {
                let fit = fitted(&problem(name, vec![run.clone()]));
                let excess = fit.cost / simple.cost - 1.0;
                // The other model is nested at an infinitely fast inner loop; the fastest inner
                // loop of 10,000 1/s has a lag of 0.1 ms, which a delay compensates only in part.
                // Half a per cent of the cost is a quarter of a per cent of the residuals.
                assert!(excess < 5e-3, "{name} {input} {seed}: {excess}");
            }
        }
    }
}

#[test]
fn a_known_fit_of_a_nested_model_is_a_starting_point() {
    let run = noisy(simulated(ModelKind::BlackBox1, "pulse", 80, &[]), 1);
    let simple = fitted(&problem("black-box-1", vec![run.clone()]));
    let whole = problem("black-box-2", vec![run]);
    let one = Options {
        starts: 1,
        ..Default::default()
    };
    let alone = fit(&whole, &one, &Quiet).expect("a fit");
    let from = fit_from(&whole, &one, &Quiet, &[&simple]).expect("a fit");
    assert_eq!((alone.starts.0, from.starts.0), (1, 2));
    // The fit of another model is ignored.
    let other = fit_from(&whole, &one, &Quiet, &[&alone]).expect("a fit");
    assert_eq!(other.starts.0, 2, "its own counts");
    assert!(other.cost <= alone.cost);
}

/// Requests a stop after this number of searches.
struct After(usize, AtomicUsize);

impl Progress for After {
    fn done(&self, _done: usize, _of: usize, _best_cost: f64) {
        self.1.fetch_add(1, Ordering::Relaxed);
    }

    fn is_stopped(&self) -> bool {
        self.1.load(Ordering::Relaxed) >= self.0
    }
}

#[test]
fn a_stopped_search_begins_no_further_start_and_returns_its_best_result() {
    let run = noisy(simulated(ModelKind::BlackBox1, "pulse", 80, &[]), 1);
    for name in ["black-box-1", "black-box-2", "grey-box", "servo-m2"] {
        let problem = problem(name, vec![run.clone()]);
        let options = Options {
            starts: 100,
            ..Default::default()
        };
        let at_once = After(0, AtomicUsize::new(0));
        let fit = fit(&problem, &options, &at_once).expect("an answer");
        assert_eq!(fit.termination, Termination::Interrupted, "{name}");
        assert_eq!(at_once.1.load(Ordering::Relaxed), 1, "{name}");
        let soon = After(3, AtomicUsize::new(0));
        super::fit(&problem, &options, &soon).expect("an answer");
        // Searches that other threads have begun are completed.
        let most = 3 + rayon::current_num_threads();
        assert!(soon.1.load(Ordering::Relaxed) <= most, "{name}");
    }
}
