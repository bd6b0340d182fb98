//! Time of one fit to many recordings of an actuator, 1,250 samples each, on one core and on all:
//! a line for each number of recordings.

use std::time::Instant;

use identification::synthetic::{noisy, simulated};
use identification::{Experiment, Options, Problem, Quiet, fit, models};
use model_core::actuator::ModelKind;

fn seconds(problem: &Problem, threads: usize) -> f64 {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let begun = Instant::now();
    let found = pool
        .expect("threads")
        .install(|| fit(problem, &Options::default(), &Quiet));
    assert!(found.expect("a fit").has_converged());
    begun.elapsed().as_secs_f64()
}

fn main() {
    let counts = std::env::args()
        .skip(1)
        .filter_map(|count| count.parse().ok());
    let mut counts: Vec<u64> = counts.collect();
    if counts.is_empty() {
        counts = vec![1, 10, 100, 1000];
    }
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let clean = simulated(ModelKind::BlackBox1, "pulse", 80, &[]).expect("a run");
    println!("| recordings | one core (s) | {cores} cores (s) | ratio |\n|---|---|---|---|");
    for count in counts {
        let run = |seed| Experiment::try_new(noisy(clean.clone(), seed)).expect("a recording");
        let runs = (0..count).map(run).collect();
        let model = models::named("black-box-1").expect("a model");
        let problem = Problem::try_new(model, runs).expect("a problem");
        let (one, all) = (seconds(&problem, 1), seconds(&problem, cores));
        println!("| {count} | {one:.3} | {all:.3} | {:.2} |", one / all);
    }
}
