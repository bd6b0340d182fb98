//! Scenarios from TOML files.

use super::Cli;

#[test]
fn a_scenario_supports_all_options() {
    let cli = Cli::new();
    cli.write(
        "s.toml",
        "model = \"board\"\nplant = \"first-order\"\npreset = \"as-measured\"\ninput = \"sine\"\n\
         duration_s = 0.5\nevery = 40\nseed = 3\npwm = \"switched\"\n[set]\nP = 10\n\
         encoder_noise_deg = 0.03\n\"input.amplitude_deg\" = 5.5\n",
    );
    let options = "board --plant first-order --preset as-measured --input sine --duration 0.5 \
                   --every 40 --seed 3 --pwm switched --set P=10 --set encoder_noise_deg=0.03 \
                   --set input.amplitude_deg=5.5";
    let [one, two] = [
        cli.text("simulate --scenario s.toml --csv -"),
        cli.text(&format!("simulate {options} --csv -")),
    ];
    assert!(one == two);
}

#[test]
fn options_override_the_scenario() {
    let cli = Cli::new();
    cli.write(
        "s.toml",
        "model = \"grey-box\"\ninput = \"sine\"\nduration_s = 1\nevery = 1\n\
         [set]\nposition_gain = 20\nKp = 2\n",
    );
    // The option's symbol overrides the name of the same parameter in the file.
    let options = "board --input pulse --duration 1.3 --every 30 --set P=9";
    let [one, two] = [
        cli.text(&format!("simulate --scenario s.toml --csv - {options}")),
        cli.text(&format!("simulate {options} --set Kp=2 --csv -")),
    ];
    assert!(one == two);
}

#[test]
fn an_input_file_is_relative_to_the_scenario_and_an_input_option_replaces_it() {
    let cli = Cli::new();
    std::fs::create_dir(cli.path("runs")).expect("the directory can be made");
    cli.write("runs/in.csv", "t,command_deg\n0,4\n");
    cli.write(
        "runs/s.toml",
        "model = \"black-box-1\"\ninput_file = \"in.csv\"\n",
    );
    let command = cli.trace("--scenario runs/s.toml").column("command_deg");
    assert_eq!(command, [4.0]);
    let command = cli
        .trace("--scenario runs/s.toml --input pulse")
        .column("command_deg");
    assert_eq!(command.len(), 5000);
    // The file of an option is relative to the working directory.
    cli.write("here.csv", "t,command_deg\n0,6\n");
    let command = cli
        .trace("--scenario runs/s.toml --input-file here.csv")
        .column("command_deg");
    assert_eq!(command, [6.0]);
}

#[test]
fn windows_line_ends_and_a_byte_order_mark_are_read() {
    let cli = Cli::new();
    cli.write(
        "s.toml",
        "\u{feff}model = \"board\"\r\nduration_s = 0.01\r\n",
    );
    assert_eq!(cli.trace("--scenario s.toml").rows.len(), 10);
}

#[test]
fn an_error_names_file_line_and_expected_value() {
    let cli = Cli::new();
    let bad = [
        ("model = \"board\"\nspeed = 1\n", "line 2, column 1"),
        (
            "model = \"board\"\nspeed = 1\n",
            "unknown field `speed`, expected one of `model`",
        ),
        ("model = \"board\n", "line 1, column 15"),
        (
            "model = \"board\"\n[set]\nP = nan\n",
            "s.toml:3: parameter position_gain is NaN",
        ),
        (
            "model = \"board\"\n[set]\nKp = 1\ngian = 1\n",
            "s.toml:4: unknown parameter `gian`",
        ),
        (
            "",
            "no model, expected one of black-box-1, black-box-2, grey-box, board",
        ),
        (
            "model = \"board\"\ninput = \"sine\"\ninput_file = \"in.csv\"\n",
            "both an input by name and an input file, expected one of them",
        ),
    ];
    for (content, message) in bad {
        cli.write("s.toml", content);
        cli.assert_error("simulate --scenario s.toml --csv -", 2, message);
    }
    cli.write("s.toml", b"\xff");
    cli.assert_error(
        "simulate --scenario s.toml",
        2,
        "s.toml: line 1 is no text in UTF-8",
    );
    cli.assert_error(
        "simulate --scenario none.toml",
        1,
        "cannot read none.toml: ",
    );
}

#[test]
fn the_scenarios_of_every_front_end_are_accepted_and_refused() {
    let cli = Cli::new();
    let cases = include_str!("../../../tests/scenarios.txt").lines();
    for line in cases.filter(|line| !line.starts_with('#')) {
        let (verdict, scenario) = line.split_once(' ').expect("a verdict and a scenario");
        let mut command = cli.actuator("simulate");
        if !scenario.contains("duration_s=") {
            command.args(["--duration", "0.01"]);
        }
        for entry in scenario.split('&') {
            let (key, value) = entry.split_once('=').expect("key=value");
            match key {
                "model" => command.arg(value),
                "duration_s" => command.args(["--duration", value]),
                "plant" | "preset" | "input" | "every" | "seed" | "pwm" => {
                    command.arg(format!("--{key}={value}"))
                }
                _ => command.args(["--set", entry]),
            };
        }
        let code = if verdict == "accept" { 0 } else { 2 };
        let output = command.output().expect("the program runs");
        assert_eq!(output.status.code(), Some(code), "{line}: {output:?}");
    }
}
