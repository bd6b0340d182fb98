//! Fits each of the paper's models to its own noisy pulse, for `benches/against_scipy.py`: writes
//! the recordings as CSV into the given directory, and one line of JSON per fit to standard output,
//! with start values, optimum and the shortest time of several fits. The last fit has a million
//! samples.

use std::fmt::Write as _;
use std::path::Path;
use std::time::Instant;

use identification::synthetic::{noisy, simulated};
use identification::{Experiment, Options, Problem, Quiet, Recording, fit, models};
use model_core::actuator::ModelKind;

const FITS: usize = 25;

/// Parameters of the grey box that are fixed in the compared programs too.
const HELD: [&str; 5] = [
    "proportional_gain",
    "integral_gain",
    "position_gain",
    "anti_windup_gain",
    "duty_limit_pct",
];

/// The response of a model at 250 Hz with encoder quantisation and noise.
fn recording(kind: ModelKind, input: &str) -> Recording {
    noisy(simulated(kind, input, 80, &[]).expect("a run"), 1)
}

fn write(recording: &Recording, path: &Path) -> std::io::Result<()> {
    let mut text = String::from("time_s,command_deg,angle_deg\n");
    let columns = recording.time_s.iter().zip(&recording.command_deg);
    for ((time, command), angle) in columns.zip(&recording.angle_deg) {
        let _ = writeln!(text, "{time},{command},{angle}");
    }
    std::fs::write(path, text)
}

/// Fits from these start values, and prints the results.
fn report(model: &str, file: &str, recording: Recording, start: &[(&str, f64)], fits: usize) {
    let model = models::named(model).expect("a model");
    let run = Experiment::try_new(recording).expect("a recording");
    let mut problem = Problem::try_new(model, vec![run]).expect("a problem");
    for (name, value) in start {
        problem.start(name, *value).expect("within its range");
    }
    // The compared programs also start at rest at zero.
    problem.fix("initial_angle_deg", 0.0).expect("a parameter");
    let options = Options {
        starts: 1,
        ..Default::default()
    };
    let mut least_ms = f64::INFINITY;
    let mut found = None;
    for _ in 0..fits {
        let began = Instant::now();
        found = Some(fit(&problem, &options, &Quiet).expect("a fit"));
        least_ms = least_ms.min(began.elapsed().as_secs_f64() * 1e3);
    }
    let found = found.expect("at least one fit");
    let values: Vec<_> = start
        .iter()
        .map(|(name, value)| {
            serde_json::json!({ "name": name, "start": value, "estimate": found.value(name) })
        })
        .collect();
    let held = HELD.iter().filter(|name| found.value(name).is_some());
    println!(
        "{}",
        serde_json::json!({
            "model": found.model, "file": file, "samples": found.samples, "ms": least_ms,
            "cost": found.cost, "iterations": found.iterations, "parameters": values,
            "fixed": held.map(|name| found.value(name)).collect::<Vec<_>>(),
        })
    );
}

fn main() {
    let directory = std::env::args().nth(1).expect("a directory to write to");
    let directory = Path::new(&directory);
    let limits = [
        ("rate_limit_up_deg_s", 200.0),
        ("rate_limit_down_deg_s", 300.0),
    ];
    let scale = [("gain", 0.9), ("offset_deg", 0.5)];
    let first = [("pole_rad_s", 20.0), ("delay_s", 0.01)];
    let second = [
        ("position_gain_per_s2", 600.0),
        ("rate_gain_per_s", 40.0),
        ("delay_s", 0.01),
    ];
    let motor = [
        ("motor_gain_up", 2.0),
        ("motor_gain_down", 2.0),
        ("motor_time_constant_s", 0.1),
        ("delay_s", 0.01),
    ];
    let cases = [
        (
            "black-box-1",
            ModelKind::BlackBox1,
            [&first[..], &limits, &scale].concat(),
        ),
        (
            "black-box-2",
            ModelKind::BlackBox2,
            [&second[..], &limits, &scale].concat(),
        ),
        ("grey-box", ModelKind::GreyBox, motor.to_vec()),
    ];
    for (model, kind, start) in &cases {
        let file = format!("{model}.csv");
        let run = recording(*kind, "pulse");
        write(&run, &directory.join(&file)).expect("the directory can be written");
        report(model, &file, run, start, FITS);
    }
    let pulse = recording(ModelKind::BlackBox1, "pulse");
    let mut long = Recording::default();
    for repeat in 0..800 {
        let from = 5.0 * f64::from(repeat);
        long.time_s.extend(pulse.time_s.iter().map(|t| t + from));
        long.command_deg.extend(&pulse.command_deg);
        long.angle_deg.extend(&pulse.angle_deg);
    }
    report("black-box-1", "", long, &cases[0].2, 1);
}
