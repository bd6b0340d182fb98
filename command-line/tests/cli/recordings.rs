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
fn a_folder_that_is_no_data_set_is_refused() {
    let cli = Cli::new();
    cli.assert_error("identify .", 2, "expected a LeRobot data set or a file");
}
