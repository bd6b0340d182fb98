//! Tests of the searches that are cut short, against complete ones.

use super::*;
use crate::engine::{Searches, all_starts, first, scouts, share};

#[test]
fn searches_that_are_followed_once_end_as_complete_ones() {
    for (model, kind, _) in truths() {
        for input in ["pulse", "variable-step", "3-2-1-1", "chirp"] {
            let clean = simulated(kind, input, 160, &[]);
            for run in [clean.clone(), noisy(clean.clone(), 1)] {
                let problem = problem(model, vec![run]);
                let unknowns = Unknowns::of(&problem).expect("unknowns");
                let options = Options::default();
                let starts = all_starts(&problem, &unknowns, &options, &Quiet, (&[], None));
                let searches = Searches {
                    problem: &problem,
                    unknowns: &unknowns,
                    limits: options.limits,
                    progress: &Quiet,
                };
                let (best, (of, at_best)) = scouts::best(&searches, &starts).expect("an optimum");
                let complete = searches.each(&starts).expect("optima");
                let (all, at_lowest) = share(&complete);
                let lowest = first(complete).expect("an optimum").cost;
                // Without noise the cost has steps where a mode begins a sample earlier:
                // residuals of a hundred-thousandth of the angle are no difference.
                let squares = problem.experiments[0].recording.angle_deg.iter();
                let nothing = 1e-10 * squares.map(|angle| angle * angle).sum::<f64>();
                let case = format!("{model} {input}: {} {lowest}", best.cost);
                assert!(best.cost <= lowest * (1.0 + 1e-9) + nothing, "{case}");
                // A complete search may end beside the optimum, at the limit of precision.
                assert!(
                    of == all && at_best >= at_lowest,
                    "{case}: {at_best} {at_lowest}"
                );
            }
        }
    }
}
