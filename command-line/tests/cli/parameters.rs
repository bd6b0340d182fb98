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
