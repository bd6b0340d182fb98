//! How fast the board's loop runs, against the same loop in C.
//!
//! `rival.c` is compiled here by `cc -O3 -march=native`. Rivals take turns in every round, so that
//! what else the machine does meets them alike; the figures are medians over the
//! rounds.

use std::{
    env,
    path::{Path, PathBuf},
    process::Command,
    thread::available_parallelism,
    time::Instant,
};

use host_sim::{
    scenario::{Scenario, Setting},
    settings::{ModelKind, PlantKind},
    simulate::{
        Simulation,
        extremes::{Extremes, campaign},
    },
};

const SECONDS: f64 = 60.0;
const ROUNDS: usize = 11;

/// Runs of one round on one core: a tenth of a second or so.
const SINGLES: usize = 40;

/// Actuators of the batch.
const BATCH: usize = 1000;

/// Rounds of the batch, which takes seconds.
const BATCH_ROUNDS: usize = 3;

/// The board on 4 s of each level, with motor gain and time constant spread by +-10 %.
fn simulations(actuators: usize, every: u64) -> Vec<Simulation> {
    let spread = |k: usize| match actuators {
        1 => 1.0,
        _ => 0.9 + 0.2 * k as f64 / (actuators - 1) as f64,
    };
    let simulation = |k| {
        let set = [
            ("motor_gain_up", 2.836 * spread(k)),
            ("motor_gain_down", 2.836 * spread(k)),
            ("motor_time_constant_s", spread(k) / 7.586),
            ("input.dwell_s", 4.0),
        ];
        let scenario = Scenario {
            model: Some(ModelKind::Board),
            input: Some("variable-step".into()),
            duration_s: Some(SECONDS),
            every: Some(every),
            set: set.map(|(name, value)| Setting::new(name, value)).into(),
            ..Default::default()
        };
        scenario.resolve().expect("a scenario that resolves")
    };
    (0..actuators).map(simulation).collect()
}

/// The bench for a second each, on levels of a fifteenth of it, with the inertia of the load
/// spread.
fn bench_simulations() -> Vec<Simulation> {
    let simulation = |k: u32| {
        let set = [
            ("load_inertia_kg_m2", 2e-6 + 1e-8 * f64::from(k)),
            ("input.dwell_s", 1.0 / 15.0),
        ];
        let scenario = Scenario {
            model: Some(ModelKind::Board),
            plant: Some(PlantKind::Drivetrain),
            input: Some("variable-step".into()),
            duration_s: Some(1.0),
            every: Some(1),
            set: set.map(|(name, value)| Setting::new(name, value)).into(),
            ..Default::default()
        };
        scenario.resolve().expect("a scenario that resolves")
    };
    (0..64).map(simulation).collect()
}

fn compile(name: &str, flags: &[&str]) -> PathBuf {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/board_loop/rival.c");
    let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let compiler = env::var("CC").unwrap_or_else(|_| "cc".into());
    let status = Command::new(&compiler)
        .args(["-O3", "-march=native"])
        .args(flags)
        .arg(&source)
        .arg("-o")
        .arg(&program)
        .args(["-lm", "-lpthread"])
        .status();
    assert!(
        status.is_ok_and(|s| s.success()),
        "`{compiler}` does not compile {}",
        source.display()
    );
    program
}

/// Seconds that the rival takes, by its own clock, and its sum.
fn rival(program: &Path, actuators: usize, threads: usize) -> (f64, f64) {
    let arguments = [actuators.to_string(), threads.to_string()];
    let output = Command::new(program)
        .args(arguments)
        .output()
        .expect("the rival runs");
    let text = String::from_utf8(output.stdout).expect("the rival prints numbers");
    let mut numbers = text
        .split_whitespace()
        .map(|n| n.parse::<f64>().expect("a number"));
    (
        numbers.next().expect("seconds"),
        numbers.next().expect("a sum"),
    )
}

fn sum(ends: &Extremes) -> f64 {
    ends.least_angle_deg
        + ends.greatest_angle_deg
        + ends.least_rate_deg_s
        + ends.greatest_rate_deg_s
}

/// Seconds for these runs one after the other, and their sum.
fn one_core(simulations: &[Simulation], times: usize) -> (f64, f64) {
    let start = Instant::now();
    let mut total = 0.0;
    for simulation in simulations.iter().cycle().take(times) {
        total += sum(&simulation.extremes().expect("a run"));
    }
    (start.elapsed().as_secs_f64(), total)
}

/// Seconds for these runs on all cores, and their sum.
fn all_cores(simulations: &[Simulation]) -> (f64, f64) {
    let start = Instant::now();
    let ends = campaign(simulations);
    let total = ends
        .iter()
        .map(|ends| sum(ends.as_ref().expect("a run")))
        .sum();
    (start.elapsed().as_secs_f64(), total)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// One rival of a comparison.
type Runner<'a> = (&'a str, Box<dyn Fn() -> (f64, f64) + 'a>);

/// Lets all take turns, and prints the median speed of each and, as the median over the rounds, the
/// ratio of the first ones to each of the others. Every line is `figure NAME = VALUE UNIT`.
fn compare(title: &str, simulated_s: f64, rounds: usize, own: &[Runner], rivals: &[Runner]) {
    let runners: Vec<_> = own.iter().chain(rivals).collect();
    let mut seconds = vec![Vec::new(); runners.len()];
    for _ in 0..rounds {
        for (taken, (_, run)) in seconds.iter_mut().zip(&runners) {
            taken.push(run().0);
        }
    }
    for ((name, _), taken) in runners.iter().zip(&seconds) {
        let speed = simulated_s / median(taken.clone());
        println!("figure {title}: {name} = {speed:.0} s/s");
    }
    let (own_s, rival_s) = seconds.split_at(own.len());
    for ((name, _), taken) in own.iter().zip(own_s) {
        for ((rival, _), rival_taken) in rivals.iter().zip(rival_s) {
            let ratios = rival_taken.iter().zip(taken).map(|(b, a)| b / a);
            let ratio = median(ratios.collect());
            println!("figure {title}: {name} to {rival} = {ratio:.2} times");
        }
    }
}

/// The rivals of a number of actuators, by name.
fn rivals<'a>(
    programs: &'a [(&'a str, PathBuf)],
    actuators: usize,
    threads: usize,
) -> Vec<Runner<'a>> {
    let runner = |(name, program): &'a (&'a str, PathBuf)| -> Runner<'a> {
        (name, Box::new(move || rival(program, actuators, threads)))
    };
    programs.iter().map(runner).collect()
}

fn main() {
    let programs = [
        ("C, 50 us plain", compile("rival-plain", &["-DPLAIN"])),
        ("C, 50 us tuned", compile("rival-stepped", &["-DSTEPPED"])),
        ("C, 50 us closed form", compile("rival-closed-form", &[])),
        ("C, 1 ms bare", compile("rival-bare", &["-DBARE"])),
        (
            "C, 50 us tuned, fast-math",
            compile("rival-stepped-fast", &["-DSTEPPED", "-ffast-math"]),
        ),
        (
            "C, 1 ms bare, fast-math",
            compile("rival-bare-fast", &["-DBARE", "-ffast-math"]),
        ),
    ];
    let (fine, fast) = (simulations(1, 1), simulations(1, 20));

    // The rivals see the same motion, but for what fixed point and rounding make of it.
    let (own, other) = (one_core(&fine, 1).1, rival(&programs[2].1, 1, 1).1);
    assert!(
        (own - other).abs() < 1e-3,
        "the loops differ: {own} and {other}"
    );

    compare(
        "60 s of one board, one core",
        SECONDS * SINGLES as f64,
        ROUNDS,
        &[
            ("50 us", Box::new(|| one_core(&fine, SINGLES))),
            ("1 ms", Box::new(|| one_core(&fast, SINGLES))),
        ],
        &rivals(&programs, SINGLES, 1),
    );
    let threads = available_parallelism().map_or(1, |n| n.get());
    let (fine, fast) = (simulations(BATCH, 1), simulations(BATCH, 20));
    compare(
        &format!("1,000 boards with spread parameters, {threads} cores"),
        SECONDS * BATCH as f64,
        BATCH_ROUNDS,
        &[
            ("50 us", Box::new(|| all_cores(&fine))),
            ("1 ms", Box::new(|| all_cores(&fast))),
        ],
        &rivals(&programs[1..], BATCH, threads),
    );
    let bench = bench_simulations();
    compare(
        "64 benches of 1 s",
        64.0,
        BATCH_ROUNDS,
        &[("side by side, all cores", Box::new(|| all_cores(&bench)))],
        &[(
            "one after the other, one core",
            Box::new(|| one_core(&bench, 64)),
        )],
    );
    let bytes = size_of::<Simulation>();
    println!("figure memory of an actuator in a batch = {bytes} bytes");
}
