//! `actuator simulate`: runs and their outputs.

use host_sim::{scenario::Scenario, settings::ModelKind};
use model_core::excitation::catalogue::Input;
use predicates::prelude::*;

use super::Cli;

const COMMON_COLUMNS: [&str; 8] = [
    "time_s",
    "command_deg",
    "command_delayed_deg",
    "angle_deg",
    "rate_deg_s",
    "duty_pct",
    "angle_meas_deg",
    "rate_meas_deg_s",
];

const MODELS: [&str; 4] = ["black-box-1", "black-box-2", "grey-box", "board"];

#[test]
fn every_model_runs_on_every_input() {
    let cli = Cli::new();
    for model in MODELS {
        for name in Input::NAMES {
            let csv = cli.trace(&format!("{model} --input {name} --every 4000"));
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
    let cli = Cli::new();
    for (name, other) in [("variable-step", "varstep"), ("3-2-1-1", "3211")] {
        let [one, two] = [name, other].map(|input| {
            cli.text(&format!(
                "simulate black-box-1 --csv - --every 4000 --input {input}"
            ))
        });
        assert!(one == two);
    }
}

#[test]
fn by_default_every_twentieth_tick_of_50_us_is_a_row() {
    let cli = Cli::new();
    let t = cli.trace("board").column("time_s");
    assert_eq!(t.len(), 5000);
    assert_eq!([t[0], t[1], t[4999]], [0.0, 0.001, 4.999]);
    let t = cli
        .trace("board --every 1 --duration 0.01")
        .column("time_s");
    assert_eq!(t.len(), 200);
    assert_eq!(t[1], 0.00005);
    let t = cli
        .trace("board --every 80 --duration 0.0101")
        .column("time_s");
    assert_eq!(t, [0.0, 0.004, 0.008]);
}

#[test]
fn a_duration_below_a_tick_is_one_tick() {
    let cli = Cli::new();
    assert_eq!(cli.trace("board --duration 1e-9").rows.len(), 1);
}

#[test]
fn csv_on_standard_output_contains_only_the_table() {
    let cli = Cli::new();
    let assert = cli
        .actuator("simulate board --duration 1.5 --csv -")
        .assert();
    assert.success().stderr("");
    // Panics if a line is not a row of numbers.
    assert_eq!(cli.trace("board --duration 1.5").rows.len(), 1500);
}

#[test]
fn a_file_gets_the_same_bytes_as_standard_output() {
    let cli = Cli::new();
    let to_file = cli.actuator("simulate grey-box --csv out.csv").assert();
    to_file.success().stdout("");
    assert!(cli.read("out.csv") == cli.text("simulate grey-box --csv -"));
}

#[test]
fn without_csv_a_summary_is_printed() {
    let cli = Cli::new();
    let text = cli.text("simulate black-box-1 --every 1");
    let line = text.lines().find(|line| line.contains("rate_deg_s"));
    let line = line.expect("the summary has a row for the rate");
    // The rate limits of the paper.
    assert!(
        line.contains("-350.000") && line.contains("240.000"),
        "{line}"
    );
}

#[test]
fn numbers_survive_the_round_trip_through_csv() {
    let cli = Cli::new();
    let scenario = Scenario {
        model: Some(ModelKind::BlackBox1),
        ..Scenario::default()
    };
    let trace = scenario
        .resolve()
        .and_then(|simulation| simulation.record());
    let rows: Vec<Vec<f64>> = trace.expect("it runs").rows().collect();
    assert!(cli.trace("black-box-1").rows == rows);
}

#[test]
fn equal_seeds_give_equal_bytes_and_different_seeds_different_noise() {
    let cli = Cli::new();
    let run = |seed: &str, noise: &str| {
        let noise = format!("--set encoder_noise_deg={noise}");
        cli.text(&format!(
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
    let cli = Cli::new();
    let run = |pwm: &str| {
        cli.text(&format!(
            "simulate board --input sine --duration 0.2 --csv - {pwm}"
        ))
    };
    assert!(run("") == run("--pwm average"));
    assert!(run("") != run("--pwm switched"));
}

#[test]
fn a_preset_changes_the_motor() {
    let cli = Cli::new();
    let fastest = |preset: &str| {
        let rate = cli
            .trace(&format!("board --preset {preset}"))
            .column("rate_deg_s");
        let up = rate.iter().copied().fold(0.0, f64::max);
        (up, rate.iter().copied().fold(0.0, f64::min))
    };
    // Motor gains times the full duty, reached to a per cent within the 90 deg of the pulse.
    let (up, down) = fastest("as-measured");
    assert!(
        (up - 240.0).abs() < 2.4 && (down + 350.0).abs() < 3.5,
        "{up} {down}"
    );
}

#[test]
fn a_preset_that_contradicts_the_paper_warns_on_standard_error() {
    let cli = Cli::new();
    let strict = cli
        .actuator("simulate grey-box --preset as-printed-strict --csv -")
        .assert();
    strict
        .success()
        .stderr(predicate::str::contains("warning: 37.4 deg/s"));
}

#[test]
fn the_bench_plant_has_its_additional_columns() {
    let cli = Cli::new();
    let csv = cli.trace("board --plant bench --duration 1.2");
    for name in [
        "current_a",
        "back_emf_v",
        "current_meas_a",
        "motor_angle_deg",
        "motor_torque_nm",
    ] {
        assert!(csv.column(name).iter().any(|value| *value != 0.0), "{name}");
    }
    let of_motor = cli.trace("board --plant first-order --duration 1.2");
    assert!(!of_motor.names.contains(&"current_a".to_owned()));
}

#[test]
fn a_load_file_applies_its_torque_from_its_time_on() {
    let cli = Cli::new();
    cli.write("load.csv", "t,torque_nm\n0.5,0.05\n0.7,-0.02\n");
    let csv = cli.trace("board --plant bench --duration 1 --load-file load.csv");
    let torque = csv.column("load_torque_nm");
    // Rows are 1 ms apart; a torque affects the outputs from the end of its first tick on.
    let torque = [499, 501, 699, 701].map(|row| torque[row]);
    assert_eq!(torque, [0.0, 0.05, 0.05, -0.02]);
    let angle = csv.column("load_angle_deg");
    assert!(angle[..=500].iter().all(|a| *a == 0.0) && angle[501] > 0.0);
}

#[test]
fn a_plot_is_an_svg_or_a_page_that_needs_no_network() {
    let cli = Cli::new();
    cli.actuator("simulate board --plot p.svg")
        .assert()
        .success()
        .stderr("plot: p.svg\n");
    let svg = cli.read("p.svg");
    let document = roxmltree::Document::parse(&svg).expect("the plot is well-formed");
    assert_eq!(document.root_element().tag_name().name(), "svg");
    // Also in combination with CSV on standard output.
    let both = cli
        .actuator("simulate board --plot p.html --csv -")
        .assert();
    both.success()
        .stdout(predicate::str::starts_with("time_s,command_deg,"));
    let html = cli.read("p.html");
    assert!(html.contains("</html>") && !html.contains("src=\"http"));
}

#[test]
fn the_help_lists_models_presets_inputs_and_the_exit_status() {
    let cli = Cli::new();
    let help = cli.text("simulate --help");
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
        cli.text("--help")
            .contains("Exit status: 0 success, 1 a file")
    );
}

#[test]
fn a_host_of_50_hz_holds_its_samples_and_the_delayed_command_shows_them() {
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
        held.column("command_delayed_deg"),
        free.column("command_delayed_deg")
    );
    // The rate of black box 1 is p (c - angle), from which the delayed command c follows.
    let arrived = |trace: &host_sim::trace::Trace, tick: usize| {
        let column = |name| trace.column(name).unwrap()[tick];
        column("rate_deg_s") / 30.0 + column("angle_deg")
    };
    let command = free.column("command_deg").unwrap();
    for tick in (11_000..12_000).step_by(7) {
        let sampled = command[(tick - 350) / 400 * 400];
        assert!((arrived(&held, tick) - sampled).abs() < 1e-9, "tick {tick}");
    }
}
