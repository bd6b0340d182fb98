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
