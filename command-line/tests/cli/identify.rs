//! `actuator identify`, `compare` and `experiment`, from a file to the results.

use super::Cli;

/// A directory with a recording of black box 1 on a pulse, `pulse.csv`.
fn cli_with_pulse() -> Cli {
    let cli = Cli::new();
    cli.text("simulate black-box-1 --input pulse --every 80 --csv pulse.csv");
    cli
}

pub fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).expect("JSON")
}

#[test]
fn a_report_is_one_file_and_a_comparison_names_the_sufficient_model() {
    let cli = cli_with_pulse();
    cli.text("simulate black-box-1 --input 3-2-1-1 --every 80 --csv other.csv");
    let text = cli.text(
        "compare pulse.csv --model black-box-1 --model black-box-2 --starts 2 --validate other.csv \
         --html report.html --json all.json",
    );
    assert!(text.contains("black-box-1 is enough"), "{text}");
    let html = cli.read("report.html");
    assert!(html.contains("Validation") && html.contains("other.csv"));
    let document = json(&cli.read("all.json"));
    assert_eq!(document["ranking"]["enough"], "black-box-1");
    assert_eq!(document["models"].as_array().map(Vec::len), Some(8));
}

#[test]
fn a_fit_that_has_not_converged_has_a_status_of_its_own_and_determines_nothing() {
    let cli = Cli::new();
    cli.text("simulate board --plant bench --input 3-2-1-1 --every 80 --csv run.csv");
    // One search from such a delay reaches its limit of iterations.
    let fit = "identify run.csv --model motor-m4 --starts 1 --start delay_s=0.3 \
        --fix supply_v=12 --parameters open.toml";
    let run = cli.actuator(fit).assert().code(3);
    let error = String::from_utf8_lossy(&run.get_output().stderr).into_owned();
    assert!(
        error.contains("error: the search has not converged: the values of motor-m4"),
        "{error}"
    );
    let file: toml::Table = cli.read("open.toml").parse().expect("TOML");
    let open = file["undetermined"].as_array().expect("a list");
    for name in ["torque_constant_nm_a", "motor_inertia_kg_m2"] {
        assert!(
            open.iter().any(|open| open.as_str() == Some(name)),
            "{open:?}"
        );
    }
    // The simulator takes them all the same.
    cli.text("simulate --parameters open.toml --duration 0.1");
}

#[test]
fn an_offset_that_is_nearly_zero_does_not_decide_which_input_is_best() {
    let cli = Cli::new();
    let command = "experiment black-box-1 --duration 6 --input variable-step --input log-chirp";
    let exact = cli.text(command);
    // What a fit without noise has estimated.
    let nearly = cli.text(&format!("{command} --set offset_deg=-5.9e-10"));
    assert_eq!(nearly, exact);
    let known = cli.text(&format!("{command} --set offset_deg=2"));
    assert_ne!(known, exact, "an offset beyond its error has a share");
}

/// The commands of the worked example, one after the other.
#[test]
fn the_worked_example_of_the_documentation_runs() {
    let document = include_str!("../../../docs/identification.md");
    let commands: Vec<&str> = document
        .lines()
        .filter_map(|line| line.strip_prefix("$ actuator "))
        .collect();
    assert_eq!(commands.len(), 9);
    let cli = Cli::new();
    let said: Vec<String> = commands.iter().map(|command| cli.text(command)).collect();
    assert!(said[2].contains("pole_rad_s"), "{}", said[2]);
    for comparison in &said[3..5] {
        assert!(comparison.contains("is enough"), "{comparison}");
    }
    for file in [
        "fit.json",
        "fit.html",
        "fitted.toml",
        "ramp.csv",
        "best.csv",
        "best-run.csv",
    ] {
        assert!(!cli.read(file).is_empty(), "{file}");
    }
}
