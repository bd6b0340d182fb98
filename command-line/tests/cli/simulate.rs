//! `actuator simulate`: what it runs and where the rows go.

use std::{
    io::{BufRead, BufReader},
    process::Stdio,
};

use host_sim::{scenario::Scenario, settings::ModelKind};
use model_core::excitation::catalogue::Input;
use predicates::prelude::*;

use super::Desk;

const COMMON_COLUMNS: [&str; 8] = [
    "t",
    "command",
    "command_delayed",
    "angle_deg",
    "rate_deg_s",
    "duty_pct",
    "angle_meas_deg",
    "rate_meas_deg_s",
];

const MODELS: [&str; 4] = ["black-box-1", "black-box-2", "grey-box", "board"];

#[test]
fn every_model_runs_on_every_input() {
    let desk = Desk::new();
    for model in MODELS {
        for name in Input::NAMES {
            let csv = desk.trace(&format!("{model} --input {name} --every 4000"));
            let input = Input::named(name).and_then(|input| input.duration_ticks().ok());
            let ticks = input.expect("the input has a duration");
            assert_eq!(
                csv.rows.len() as u64,
                ticks.div_ceil(4000),
                "{model} {name}"
            );
            assert_eq!(csv.names[..8], COMMON_COLUMNS, "{model} {name}");
            assert!(csv.rows.iter().flatten().all(|value| value.is_finite()));
        }
    }
}

#[test]
fn the_referees_names_of_the_inputs_are_known_too() {
    let desk = Desk::new();
    for (name, other) in [("variable-step", "varstep"), ("3-2-1-1", "3211")] {
        let [one, two] = [name, other].map(|input| {
            desk.text(&format!(
                "simulate black-box-1 --csv - --every 4000 --input {input}"
            ))
        });
        assert!(one == two);
    }
}

#[test]
fn a_row_is_made_of_every_twentieth_tick_of_50_us_unless_told_otherwise() {
    let desk = Desk::new();
    let t = desk.trace("board").column("t");
    assert_eq!(t.len(), 5000);
    assert_eq!([t[0], t[1], t[4999]], [0.0, 0.001, 4.999]);
    let t = desk.trace("board --every 1 --duration 0.01").column("t");
    assert_eq!(t.len(), 200);
    assert_eq!(t[1], 0.00005);
    let t = desk.trace("board --every 80 --duration 0.0101").column("t");
    assert_eq!(t, [0.0, 0.004, 0.008]);
}

#[test]
fn a_duration_below_a_tick_is_one_tick() {
    let desk = Desk::new();
    assert_eq!(desk.trace("board --duration 1e-9").rows.len(), 1);
}

#[test]
fn with_a_dash_nothing_but_csv_is_written() {
    let desk = Desk::new();
    let assert = desk
        .actuator("simulate board --duration 1.5 --csv -")
        .assert();
    assert.success().stderr("");
    // Panics where a line is no row of numbers.
    assert_eq!(desk.trace("board --duration 1.5").rows.len(), 1500);
}

#[test]
fn a_file_gets_the_same_bytes_as_standard_output() {
    let desk = Desk::new();
    let to_file = desk.actuator("simulate grey-box --csv out.csv").assert();
    to_file.success().stdout("");
    assert!(desk.read("out.csv") == desk.text("simulate grey-box --csv -"));
}

#[test]
fn without_csv_a_summary_is_printed() {
    let desk = Desk::new();
    let text = desk.text("simulate black-box-1 --every 1");
    let line = text.lines().find(|line| line.contains("rate_deg_s"));
    let line = line.expect("the summary has a row for the rate");
    // The rate limits of the paper.
    assert!(
        line.contains("-350.000") && line.contains("240.000"),
        "{line}"
    );
}

#[test]
fn numbers_come_back_exactly() {
    let desk = Desk::new();
    let scenario = Scenario {
        model: Some(ModelKind::BlackBox1),
        ..Scenario::default()
    };
    let trace = scenario
        .resolve()
        .and_then(|simulation| simulation.record());
    let rows: Vec<Vec<f64>> = trace.expect("it runs").rows().collect();
    assert!(desk.trace("black-box-1").rows == rows);
}

#[test]
fn equal_seeds_give_equal_bytes_and_others_do_not_where_there_is_noise() {
    let desk = Desk::new();
    let run = |seed: &str, noise: &str| {
        let noise = format!("--set encoder_noise_deg={noise}");
        desk.text(&format!(
            "simulate board --duration 1.2 --csv - {noise} {seed}"
        ))
    };
    assert!(run("--seed 7", "0.03") == run("--seed 7", "0.03"));
    assert!(run("", "0.03") == run("--seed 0", "0.03"));
    assert!(run("--seed 7", "0.03") != run("--seed 8", "0.03"));
    assert!(run("--seed 7", "0") == run("--seed 8", "0"));
}

#[test]
fn the_bridge_is_averaged_or_switched() {
    let desk = Desk::new();
    let run = |pwm: &str| {
        desk.text(&format!(
            "simulate board --input sine --duration 0.2 --csv - {pwm}"
        ))
    };
    assert!(run("") == run("--pwm average"));
    assert!(run("") != run("--pwm switched"));
}

#[test]
fn a_preset_changes_the_motor() {
    let desk = Desk::new();
    let fastest = |preset: &str| {
        let rate = desk
            .trace(&format!("board --preset {preset}"))
            .column("rate_deg_s");
        let up = rate.iter().copied().fold(0.0, f64::max);
        (up, rate.iter().copied().fold(0.0, f64::min))
    };
    // Motor gains times the whole duty, reached to a per cent within the 90 deg of the pulse.
    let (up, down) = fastest("as-measured");
    assert!(
        (up - 240.0).abs() < 2.4 && (down + 350.0).abs() < 3.5,
        "{up} {down}"
    );
}

#[test]
fn a_preset_that_contradicts_the_paper_says_so_on_standard_error() {
    let desk = Desk::new();
    let strict = desk
        .actuator("simulate grey-box --preset as-printed-strict --csv -")
        .assert();
    strict
        .success()
        .stderr(predicate::str::contains("warning: 37.4 deg/s"));
}

#[test]
fn the_bench_shows_what_only_it_has() {
    let desk = Desk::new();
    let csv = desk.trace("board --plant bench --duration 1.2");
    for name in [
        "current_a",
        "back_emf_v",
        "current_meas_a",
        "motor_angle_deg",
        "motor_torque_nm",
    ] {
        assert!(csv.column(name).iter().any(|value| *value != 0.0), "{name}");
    }
    let of_motor = desk.trace("board --plant first-order --duration 1.2");
    assert!(!of_motor.names.contains(&"current_a".to_owned()));
}

#[test]
fn a_load_file_pulls_at_the_bench_from_its_time_on() {
    let desk = Desk::new();
    desk.write("load.csv", "t,torque_nm\n0.5,0.05\n0.7,-0.02\n");
    let csv = desk.trace("board --plant bench --duration 1 --load-file load.csv");
    let torque = csv.column("load_torque_nm");
    // Rows are 1 ms apart; a torque is shown from the end of its first tick on.
    let torque = [499, 501, 699, 701].map(|row| torque[row]);
    assert_eq!(torque, [0.0, 0.05, 0.05, -0.02]);
    let angle = csv.column("load_angle_deg");
    assert!(angle[..=500].iter().all(|a| *a == 0.0) && angle[501] > 0.0);
}

#[test]
fn a_plot_is_an_svg_or_a_page_that_needs_no_network() {
    let desk = Desk::new();
    desk.actuator("simulate board --plot p.svg")
        .assert()
        .success()
        .stderr("plot: p.svg\n");
    let svg = desk.read("p.svg");
    let document = roxmltree::Document::parse(&svg).expect("the plot is well-formed");
    assert_eq!(document.root_element().tag_name().name(), "svg");
    // Beside CSV on standard output too.
    let both = desk
        .actuator("simulate board --plot p.html --csv -")
        .assert();
    both.success()
        .stdout(predicate::str::starts_with("t,command,"));
    let html = desk.read("p.html");
    assert!(html.contains("</html>") && !html.contains("src=\"http"));
}

#[test]
fn a_reader_that_has_enough_is_no_error() {
    let mut child = std::process::Command::new(assert_cmd::cargo::cargo_bin!("actuator"))
        .args(["simulate", "black-box-1", "--duration", "100", "--csv", "-"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let mut line = String::new();
    let mut stdout = BufReader::new(child.stdout.take().expect("it was piped"));
    stdout.read_line(&mut line).expect("the header comes");
    drop(stdout);
    let output = child.wait_with_output().expect("the program ends");
    assert!(output.status.success(), "{output:?}");
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
    assert!(line.starts_with("t,command,"));
}

#[test]
fn the_help_names_models_presets_inputs_and_the_exit_status() {
    let desk = Desk::new();
    let help = desk.text("simulate --help");
    let presets = model_core::presets::PRESETS
        .iter()
        .map(|preset| preset.name);
    for name in MODELS
        .into_iter()
        .chain(Input::NAMES.iter().copied())
        .chain(presets)
    {
        assert!(help.contains(&format!("- {name}:")), "{name}");
    }
    assert!(
        desk.text("--help")
            .contains("Exit status: 0 success, 1 a file")
    );
}

#[test]
fn a_host_of_50_hz_holds_what_it_samples_and_the_delayed_command_shows_what_it_was_given() {
    let scenario = |host_period_s: f64| Scenario {
        model: Some(ModelKind::BlackBox1),
        input: Some("ramp".into()),
        every: Some(1),
        duration_s: Some(1.0),
        set: vec![host_sim::scenario::Setting::new(
            "host_period_s",
            host_period_s,
        )],
        ..Default::default()
    };
    let run = |host_period_s| scenario(host_period_s).resolve().unwrap().record().unwrap();
    let (held, free) = (run(0.02), run(0.0));
    assert_eq!(
        held.column("command_delayed"),
        free.column("command_delayed")
    );
    // Black box 1 turns at p (c - angle): the command that arrived can be read off its rate.
    let arrived = |trace: &host_sim::trace::Trace, tick: usize| {
        let column = |name| trace.column(name).unwrap()[tick];
        column("rate_deg_s") / 30.0 + column("angle_deg")
    };
    let command = free.column("command").unwrap();
    for tick in (11_000..12_000).step_by(7) {
        let sampled = command[(tick - 350) / 400 * 400];
        assert!((arrived(&held, tick) - sampled).abs() < 1e-9, "tick {tick}");
    }
}
