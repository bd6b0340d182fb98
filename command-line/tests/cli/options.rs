//! Invalid options of `actuator identify`, `compare` and `experiment`, and their messages.

use super::Cli;

/// A directory with a recording of black box 1 on a pulse, `pulse.csv`.
fn cli_with_pulse() -> Cli {
    let cli = Cli::new();
    cli.text("simulate black-box-1 --input pulse --every 80 --csv pulse.csv");
    cli
}

#[test]
fn a_file_may_have_its_own_window_and_known_values() {
    let cli = cli_with_pulse();
    cli.text("simulate black-box-1 --input 3-2-1-1 --every 80 --csv other.csv");
    let identify = "identify pulse.csv --model black-box-1 --starts 1 --validate other.csv";
    let samples = |options: &str| {
        let text = cli.text(&format!("{identify} {options} --json -"));
        let document: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        let of = |part: &str| document["models"][0][part][0]["samples"].as_u64();
        [of("experiments"), of("validation")].map(|n| n.expect("a number"))
    };
    let [pulse, other] = samples("");
    assert_eq!(samples("--window 0:3"), [751, 751]);
    assert_eq!(samples("--window pulse.csv@0:3"), [751, other]);
    assert_eq!(samples("--window 0:3 --window other.csv@0:2"), [751, 501]);
    assert!(pulse > 751 && other > 751, "{pulse} {other}");
    for (options, message) in [
        (
            "--window puls.csv@0:3",
            "--window is for puls.csv, expected one of pulse.csv, other.csv",
        ),
        (
            "--known puls.csv@gain=1",
            "--known is for puls.csv, expected one of pulse.csv, other.csv",
        ),
        (
            "--window pulse.csv@0:3 --window pulse.csv@0:2",
            "--window is given twice for pulse.csv, expected it once",
        ),
        (
            "--window 0:3 --window 0:2",
            "--window is given twice for all files, expected it once",
        ),
        ("--window pulse.csv@3", "expected FROM:TO"),
        ("--known pulse.csv@gain", "expected NAME=VALUE"),
    ] {
        cli.assert_error(&format!("{identify} {options}"), 2, message);
    }
}

#[test]
fn the_load_of_each_run_is_known() {
    let cli = Cli::new();
    let run = "simulate board --plant bench --every 80";
    for (name, load) in [("free.csv", 0.0), ("loaded.csv", 0.1)] {
        cli.text(&format!("{run} --set load_torque_nm={load} --csv {name}"));
    }
    let identify = "identify free.csv loaded.csv --model motor-m1 --starts 1 --fix \
                    winding_resistance_ohm=7.7 --fix supply_v=6 --json -";
    let cost = |options: &str| {
        let text = cli.text(&format!("{identify} {options}"));
        let document: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        document["models"][0]["cost_deg2"]
            .as_f64()
            .expect("a number")
    };
    let [none, right] = ["", "--known loaded.csv@load_torque_nm=0.1"].map(cost);
    assert!(right < 0.01 * none, "{right} {none}");
}

#[test]
fn the_error_of_exclusive_options_names_both() {
    let cli = cli_with_pulse();
    for (options, message) in [
        ("--fix gain=1 --free gain", "fix and free both name gain"),
        (
            "--fix gain=1 --bound gain=0.5:2",
            "fix and bound both name gain",
        ),
        (
            "--fix gain=1 --start gain=1",
            "fix and start both name gain",
        ),
        ("--fix gain=1 --fix gain=2", "fix names gain twice"),
        ("--own gain --share gain", "own and share both name gain"),
    ] {
        let command = format!("identify pulse.csv --model black-box-1 --starts 1 {options}");
        cli.assert_error(&command, 2, message);
    }
    cli.assert_error(
        "experiment black-box-1 --fix pole_rad_s --free pole_rad_s",
        2,
        "--fix and --free both name pole_rad_s",
    );
    cli.text(
        "identify pulse.csv --model black-box-1 --starts 1 --fix gain=1 --bound pole_rad_s=5:80 \
         --start pole_rad_s=20 --share delay_s",
    );
}

#[test]
fn an_experiment_expects_the_parameters_of_its_own_model() {
    let cli = cli_with_pulse();
    cli.text("identify pulse.csv --model black-box-1 --starts 1 --parameters one.toml");
    cli.assert_error(
        "experiment black-box-2 --parameters one.toml",
        2,
        "one.toml has the parameters of black-box-1, expected those of black-box-2",
    );
    cli.text("experiment black-box-1 --parameters one.toml --input doublet");
}

#[test]
fn frequency_and_damping_of_a_recorded_oscillator_are_recovered() {
    let cli = Cli::new();
    cli.write(
        "two.toml",
        "model = \"black-box-2\"\n[set]\nposition_gain_per_s2 = 400.0\nrate_gain_per_s = 30.0\n",
    );
    let text =
        cli.text("experiment black-box-2-oscillator --parameters two.toml --input doublet --json");
    let document: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let parameters = document["inputs"][0]["parameters"].as_array();
    let value = |name: &str| {
        let mut all = parameters.expect("a list").iter();
        all.find(|p| p["name"] == name).map(|p| p["value"].clone())
    };
    // sqrt(400), and 30/(2 sqrt(400)).
    assert_eq!(value("natural_frequency_rad_s"), Some(20.0.into()));
    assert_eq!(value("damping"), Some(0.75.into()));
}

#[test]
fn inputs_are_designed_for_models_with_a_command() {
    let cli = Cli::new();
    let message = "motor-m1 takes the duty of its motor, expected one of black-box-1,";
    cli.assert_error("experiment motor-m1", 2, message);
}

#[test]
fn completions_and_manual_pages_name_every_command() {
    let cli = Cli::new();
    let help = cli.text("--help");
    let listed = help
        .lines()
        .skip_while(|line| !line.starts_with("Commands:"));
    let listed = listed.skip(1).take_while(|line| !line.is_empty());
    let commands: Vec<_> = listed
        .filter(|line| line.starts_with("  ") && !line.starts_with("   "))
        .filter_map(|line| line.split_whitespace().next())
        .filter(|name| *name != "help")
        .collect();
    assert!(commands.len() > 15, "{commands:?}");
    for shell in ["bash", "zsh", "fish", "powershell"] {
        let text = cli.text(&format!("completions {shell}"));
        for command in &commands {
            assert!(text.contains(command), "{shell}: {command}");
        }
    }
    cli.actuator("manual pages").assert().success();
    for command in &commands {
        let page = cli.read(&format!("pages/actuator-{command}.1"));
        assert!(page.contains(&format!("actuator\\-{command}")), "{page}");
    }
}

#[test]
fn json_goes_to_standard_output_or_to_a_file_in_every_command_that_computes() {
    let cli = Cli::new();
    cli.text("simulate black-box-1 --every 80 --csv run.csv");
    for command in [
        "identify run.csv --model black-box-1 --starts 1",
        "compare run.csv --model black-box-1",
        "experiment black-box-1 --duration 2 --input doublet",
        "tune",
    ] {
        let printed = cli.text(&format!("{command} --json"));
        assert_eq!(
            cli.text(&format!("{command} --json -")),
            printed,
            "{command}"
        );
        assert!(!cli.text(&format!("{command} --json out.json")).is_empty());
        assert_eq!(cli.read("out.json"), printed, "{command}");
    }
}
