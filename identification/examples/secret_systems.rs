//! Faulty recordings of systems with secret parameters, a hundred of each fault: a table of the
//! share of 95 % intervals that cover the truth, for `docs/identification.md`. The number of
//! systems may be given as an argument.

use identification::evaluation::{Fault, Outcome, outcome};
use rayon::prelude::*;

const SYSTEMS: u64 = 100;

/// Standard errors from which an estimate is wrong and not unlucky.
const WRONG: f64 = 5.0;

fn main() {
    let systems = std::env::args().nth(1).and_then(|n| n.parse().ok());
    let systems: u64 = systems.unwrap_or(SYSTEMS);
    println!(
        "| fault of the recording | doubted (%) | covered (%) | covered if not doubted (%) | wrong, not doubted (%) |"
    );
    println!("|---|---|---|---|---|");
    for (index, fault) in Fault::ALL.into_iter().enumerate() {
        eprintln!("{} of {}: {}", index + 1, Fault::ALL.len(), fault.name());
        let outcomes: Vec<Outcome> = (0..systems)
            .into_par_iter()
            .filter_map(|seed| {
                let outcome = outcome(fault, seed);
                if let Some(o) = outcome.filter(|o| o.worst > WRONG && !o.is_doubted) {
                    eprintln!(
                        "  system {seed}: {} is off by {:.1} standard errors",
                        o.worst_parameter, o.worst
                    );
                }
                outcome
            })
            .collect();
        let trusted = || outcomes.iter().filter(|o| !o.is_doubted);
        let covered = |of: &[&Outcome]| {
            let sum = |f: fn(&Outcome) -> usize| of.iter().map(|o| f(o)).sum::<usize>() as f64;
            100.0 * sum(|o| o.covered) / sum(|o| o.intervals)
        };
        let share = |count: usize| 100.0 * count as f64 / outcomes.len() as f64;
        let text = |percent: f64| match percent.is_nan() {
            true => "-".into(),
            false => format!("{percent:.0}"),
        };
        println!(
            "| {} | {} | {} | {} | {} |",
            fault.name(),
            text(share(outcomes.len() - trusted().count())),
            text(covered(&outcomes.iter().collect::<Vec<_>>())),
            text(covered(&trusted().collect::<Vec<_>>())),
            text(share(trusted().filter(|o| o.worst > WRONG).count())),
        );
    }
}
