//! Forty starts at a quarter to four times the true values: number of starts from which a single
//! search, and a search with several starts, reach the optimum. One line per model and input.

use identification::synthetic::{noisy, simulated};
use identification::{Experiment, Options, Problem, Quiet, Recording, Role, fit, models};
use model_core::actuator::ModelKind;
use model_core::sensors::noise::Noise;

const STARTS: u64 = 40;

/// The response of a model at 250 Hz with encoder quantisation and noise.
fn recording(kind: ModelKind, input: &str) -> Recording {
    noisy(simulated(kind, input, 80, &[]).expect("a run"), 1)
}

/// The problem with start values at the true values times random factors from 1/4 to 4.
fn scattered(problem: &Problem, truth: &[f64], start: u64) -> Problem {
    let mut problem = problem.clone();
    let mut noise = Noise::new(start, 77);
    for (spec, truth) in problem.specs.iter_mut().zip(truth) {
        let is_of_the_run = spec.parameter.name.starts_with("initial");
        if spec.role == Role::Fixed || is_of_the_run || *truth == 0.0 {
            continue;
        }
        let factor = 4.0_f64.powf(noise.gaussian(0.7).clamp(-1.0, 1.0));
        spec.start = (truth * factor).clamp(spec.low, spec.high);
    }
    problem
}

fn row(model: &str, kind: ModelKind, input: &str) {
    let run = Experiment::try_new(recording(kind, input)).expect("a recording");
    let model = models::named(model).expect("a model");
    let problem = Problem::try_new(model, vec![run]).expect("a problem");
    let best = fit(&problem, &Options::default(), &Quiet).expect("a fit");
    let found = |name: &str| best.value(name).expect("an estimate");
    let truth: Vec<f64> = problem
        .specs
        .iter()
        .map(|s| found(s.parameter.name))
        .collect();
    let (mut alone, mut together) = (0, 0);
    for start in 0..STARTS {
        let scattered = scattered(&problem, &truth, start);
        let ends_there = |starts| {
            let options = Options {
                starts,
                seed: start,
                ..Default::default()
            };
            let fit = fit(&scattered, &options, &Quiet).expect("a fit");
            usize::from(fit.cost <= best.cost * (1.0 + 1e-6))
        };
        alone += ends_there(1);
        together += ends_there(Options::default().starts);
    }
    println!(
        "{:12} {input:14} one start {alone:2}, all {together:2} of {STARTS}",
        best.model
    );
}

fn main() {
    for (model, kind) in [
        ("black-box-1", ModelKind::BlackBox1),
        ("black-box-2", ModelKind::BlackBox2),
        ("grey-box", ModelKind::GreyBox),
    ] {
        for input in ["pulse", "variable-step", "ramp", "chirp", "sine", "3-2-1-1"] {
            row(model, kind, input);
        }
    }
}
