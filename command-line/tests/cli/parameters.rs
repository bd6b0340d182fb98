//! Listing and setting of parameters.

use serde_json::Value;

use super::Cli;

const TABLES: [&str; 6] = [
    "simulate black-box-1",
    "simulate black-box-2",
    "simulate grey-box",
    "simulate board",
    "simulate board --plant bench --input chirp",
    "tune",
];

/// Output of `--list-parameters --json`.
fn list(cli: &Cli, command: &str) -> Vec<Value> {
    let text = cli.text(&format!("{command} --list-parameters --json"));
    serde_json::from_str(&text).expect("the list is JSON")
}

fn text<'a>(row: &'a Value, key: &str) -> &'a str {
    row[key]
        .as_str()
        .unwrap_or_else(|| panic!("{key} of {row}"))
}

#[test]
fn every_parameter_has_a_unit_a_range_and_a_source() {
    let cli = Cli::new();
    for command in TABLES {
        let rows = list(&cli, command);
        assert!(rows.len() > 5, "{command}");
        for row in rows {
            for key in ["name", "unit", "meaning", "source"] {
                assert!(!text(&row, key).is_empty(), "{command}: {key} of {row}");
            }
            // Infinity is written as null.
            let bound = |key: &str, otherwise| row[key].as_f64().unwrap_or(otherwise);
            let (min, max) = (bound("min", f64::NEG_INFINITY), bound("max", f64::INFINITY));
            let default = bound("default", f64::INFINITY);
            assert!(min < max && (min..=max).contains(&default), "{row}");
        }
    }
}

#[test]
fn names_and_symbols_of_parameters_are_unique() {
    let cli = Cli::new();
    for command in TABLES {
        let rows = list(&cli, command);
        let input = |row: &Value| text(row, "name").starts_with("input.");
        let rows: Vec<_> = rows.iter().filter(|row| !input(row)).collect();
        let names = rows
            .iter()
            .flat_map(|row| [text(row, "name"), text(row, "symbol")]);
        let mut names: Vec<_> = names.filter(|name| !name.is_empty()).collect();
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count, "{command}");
    }
}

#[test]
fn every_parameter_can_be_set_by_name_and_by_symbol() {
    let cli = Cli::new();
    for command in TABLES {
        for key in ["name", "symbol"] {
            let rows = list(&cli, command);
            let settable = |row: &&Value| {
                // A tuning accepts one goal, and parameters of the input have the prefix `input.`.
                let name = text(row, "name");
                let other_goal = ["bandwidth_hz", "phase_margin_deg"].contains(&name);
                let hidden = key == "symbol" && name.starts_with("input.");
                let refused = hidden || command == "tune" && other_goal;
                !text(row, key).is_empty() && !refused
            };
            let bound = |row: &Value| row["min"].as_f64().or(row["max"].as_f64());
            let mut arguments = command.to_owned();
            for row in rows.iter().filter(settable) {
                let value = bound(row).expect("one of the bounds is finite");
                arguments += &format!(" --set {}={value}", text(row, key));
            }
            for row in list(&cli, &arguments).iter().filter(settable) {
                assert_eq!(row["value"].as_f64(), bound(row), "{command}: {row}");
            }
        }
    }
}

#[test]
fn the_last_of_two_values_is_used_for_name_and_symbol() {
    let cli = Cli::new();
    let value = |sets: &str| {
        let rows = list(&cli, &format!("simulate board {sets}"));
        let row = rows.iter().find(|row| text(row, "name") == "position_gain");
        row.and_then(|row| row["value"].as_f64())
    };
    assert_eq!(value("--set position_gain=3 --set P=4"), Some(4.0));
    assert_eq!(value("--set P=4 --set position_gain=3"), Some(3.0));
}

#[test]
fn the_list_shows_the_values_after_preset_scenario_and_options() {
    let cli = Cli::new();
    cli.write("s.toml", "[set]\nP = 5\n");
    let options = "--scenario s.toml --preset as-measured --input sine --set input.f=2";
    let rows = list(&cli, &format!("simulate board {options}"));
    let value = |name: &str| {
        let row = rows.iter().find(|row| text(row, "name") == name);
        row.unwrap_or_else(|| panic!("{name}"))["value"].as_f64()
    };
    assert_eq!(value("position_gain"), Some(5.0));
    assert_eq!(value("motor_gain_down"), Some(3.5));
    assert_eq!(value("input.frequency_hz"), Some(2.0));
}

#[test]
fn the_table_shows_the_same_parameters_as_the_json() {
    let cli = Cli::new();
    let table = cli.text("simulate grey-box --list-parameters");
    for row in list(&cli, "simulate grey-box") {
        for key in ["name", "unit", "meaning", "source"] {
            assert!(table.contains(text(&row, key)), "{key} of {row}");
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
fn the_list_fits_a_terminal_of_80_columns() {
    let cli = Cli::new();
    let program = assert_cmd::cargo::cargo_bin!("actuator");
    for model in [
        "board --plant bench",
        "black-box-1",
        "grey-box --input multisine",
    ] {
        let list = format!(
            "stty cols 80 rows 24; {} simulate {model} --list-parameters",
            program.display()
        );
        let output = std::process::Command::new("script")
            .args(["--quiet", "--command", &list, "/dev/null"])
            .current_dir(cli.path("."))
            .stdin(std::process::Stdio::null())
            .output()
            .expect("the terminal of util-linux");
        let text = String::from_utf8_lossy(&output.stdout);
        assert!(
            text.contains("delay_s = ") && text.contains("\r\n    from 0 to 1,"),
            "{text}"
        );
        let widest = text
            .lines()
            .map(|line| line.trim_end().chars().count())
            .max();
        assert!(widest <= Some(80), "{model}: {widest:?}");
    }
}
