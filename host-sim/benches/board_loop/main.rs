//! How fast the board's loop runs, against the same loop in C.
//!
//! `rival.c` is compiled here by `cc -O3 -march=native`. Rivals take turns in every round, so that
//! what else the machine does meets them alike; the figures are medians over the rounds.

use std::{
    env,
    path::{Path, PathBuf},
    process::Command,
    thread::available_parallelism,
    time::Instant,
};

use host_sim::{
    scenario::{Scenario, Setting},
    settings::ModelKind,
    simulate::{
        Simulation,
        extremes::{Extremes, campaign},
    },
    table::{Cell, Table},
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

/// Lets them take turns; the last is the one that the others are measured against.
fn compare(title: &str, simulated_s: f64, rounds: usize, runners: &[Runner]) {
    let mut seconds = vec![Vec::new(); runners.len()];
    for _ in 0..rounds {
        for (taken, (_, run)) in seconds.iter_mut().zip(runners) {
            taken.push(run().0);
        }
    }
    let base = seconds[runners.len() - 1].clone();
    let columns = [
        ("", ""),
        ("simulated seconds per second", ""),
        ("ratio to the last", ""),
    ];
    let mut table = Table::new(title, &columns);
    for ((name, _), taken) in runners.iter().zip(seconds) {
        let ratio = median(
            base.iter()
                .zip(&taken)
                .map(|(base, own)| base / own)
                .collect(),
        );
        table.push([
            Cell::from(*name),
            Cell::Number(simulated_s / median(taken), 0),
            Cell::Number(ratio, 2),
        ]);
    }
    println!("{}", table.to_terminal(100));
}

fn main() {
    let plain = compile("rival-plain", &["-DPLAIN"]);
    let stepped = compile("rival-stepped", &["-DSTEPPED"]);
    let tuned = compile("rival-closed-form", &[]);
    let (fine, fast) = (simulations(1, 1), simulations(1, 20));

    // The rivals see the same motion, but for what fixed point and rounding make of it.
    let (own, other) = (one_core(&fine, 1).1, rival(&tuned, 1, 1).1);
    assert!(
        (own - other).abs() < 1e-3,
        "the loops differ: {own} and {other}"
    );

    let threads = available_parallelism().map_or(1, |n| n.get());
    compare(
        "60 s of the board's loop, one core",
        SECONDS * SINGLES as f64,
        ROUNDS,
        &[
            (
                "this program, 1 ms steps",
                Box::new(|| one_core(&fast, SINGLES)),
            ),
            (
                "this program, 50 us steps",
                Box::new(|| one_core(&fine, SINGLES)),
            ),
            ("C, plain", Box::new(|| rival(&plain, SINGLES, 1))),
            ("C, tuned loops", Box::new(|| rival(&stepped, SINGLES, 1))),
            ("C, closed form", Box::new(|| rival(&tuned, SINGLES, 1))),
        ],
    );
    let (fine, fast) = (simulations(BATCH, 1), simulations(BATCH, 20));
    compare(
        &format!("1,000 actuators with spread parameters, {threads} cores"),
        SECONDS * BATCH as f64,
        BATCH_ROUNDS,
        &[
            ("this program, 1 ms steps", Box::new(|| all_cores(&fast))),
            ("this program, 50 us steps", Box::new(|| all_cores(&fine))),
            ("C, plain", Box::new(|| rival(&plain, BATCH, threads))),
            (
                "C, tuned loops",
                Box::new(|| rival(&stepped, BATCH, threads)),
            ),
            ("C, closed form", Box::new(|| rival(&tuned, BATCH, threads))),
        ],
    );
}
