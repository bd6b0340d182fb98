//! Recordings as people have them, from the file to a fit.

use super::Cli;

/// A run of black box 1 on a pulse at 250 Hz.
fn run() -> String {
    Cli::new().text("simulate black-box-1 --input pulse --every 80 --csv -")
}

/// The fitted pole, 1/s, of what this command reads.
fn pole(cli: &Cli, input: &str, arguments: &str) -> f64 {
    let mut command = cli.actuator(&format!(
        "identify {arguments} --model black-box-1 --starts 1 --json -"
    ));
    let output = command.write_stdin(input).assert().success();
    let document: serde_json::Value =
        serde_json::from_slice(&output.get_output().stdout).expect("JSON");
    let parameters = document["models"][0]["parameters"]
        .as_array()
        .expect("a list");
    let pole = parameters.iter().find(|p| p["name"] == "pole_rad_s");
    pole.and_then(|p| p["estimate"].as_f64()).expect("a number")
}

#[test]
fn what_simulate_writes_to_standard_output_is_read_from_standard_input() {
    let cli = Cli::new();
    assert!((pole(&cli, &run(), "-") / 30.0 - 1.0).abs() < 1e-3);
    // A comparison reads its files twice.
    let mut compare = cli.actuator("compare - --model black-box-1 --starts 1");
    compare.write_stdin(run()).assert().success();
}

#[test]
fn samples_at_a_rate_and_a_time_without_unit_lead_to_the_same_fit() {
    let cli = Cli::new();
    let text = run();
    let names: Vec<&str> = text.lines().next().expect("a header").split(',').collect();
    let place = |name| names.iter().position(|n| *n == name).expect("a column");
    let (command, angle) = (place("command_deg"), place("angle_deg"));
    let mut untimed = String::from("# command_deg angle_deg\n");
    let mut in_ms = String::from("time;command [deg];angle [deg]\n");
    for (row, line) in text.lines().skip(1).enumerate() {
        let fields: Vec<&str> = line.split(',').collect();
        let (command, angle) = (fields[command], fields[angle]);
        untimed += &format!("{command} {angle}\n");
        in_ms += &format!("{};{command};{angle}\n", 4 * row);
    }
    cli.write("untimed.txt", untimed);
    cli.write("ms.csv", in_ms);
    for arguments in ["untimed.txt --rate 250", "ms.csv"] {
        assert!(
            (pole(&cli, "", arguments) / 30.0 - 1.0).abs() < 1e-3,
            "{arguments}"
        );
    }
    cli.assert_error("identify untimed.txt", 2, "--rate HZ");
    cli.assert_error(
        "identify untimed.txt --rate 0",
        2,
        "expected a positive number of Hz",
    );
}

#[test]
fn commands_and_angles_in_rows_of_their_own_are_read() {
    let cli = Cli::new();
    let trace = cli.trace("black-box-1 --input pulse --every 80");
    let [time, command, angle] =
        ["time_s", "command_deg", "angle_deg"].map(|name| trace.column(name));
    // As PlotJuggler writes two topics: more rows than the starting values are estimated from.
    let mut text = String::from("__time,/servo/command/deg,/servo/angle/deg\n");
    for ((time, command), angle) in time.iter().zip(&command).zip(&angle) {
        text += &format!("{time},{command},\n{},,{angle}\n", time + 1e-6);
    }
    cli.write("topics.csv", text);
    // The angles are those of 1 us before.
    assert!((pole(&cli, "", "topics.csv") / 30.0 - 1.0).abs() < 1e-3);
}

#[test]
fn a_folder_that_is_no_data_set_is_refused() {
    let cli = Cli::new();
    cli.assert_error("identify .", 2, "expected a LeRobot data set or a file");
}
