//! `actuator tune`: from a motor and a target bandwidth to gains for the board.

use serde_json::Value;

use super::Cli;

/// Output of `actuator tune --json`.
fn tune(cli: &Cli, options: &str) -> Value {
    serde_json::from_str(&cli.text(&format!("tune --json {options}"))).expect("JSON")
}

fn number(value: &Value, pointer: &str) -> f64 {
    let number = value.pointer(pointer).and_then(Value::as_f64);
    number.unwrap_or_else(|| panic!("{pointer} of {value}"))
}

/// The command line that a tuning prints, without the name of the program.
fn simulate_command(tuning: &Value) -> &str {
    let command = tuning["simulate"]
        .as_str()
        .expect("there is a command line");
    command
        .strip_prefix("actuator simulate ")
        .expect("it is ours")
}

#[test]
fn without_options_the_gains_are_the_boards_own() {
    let cli = Cli::new();
    assert_eq!(tune(&cli, "")["simulate"], "actuator simulate board");
}

#[test]
fn the_table_shows_gains_margins_and_the_command_to_simulate_them() {
    let cli = Cli::new();
    let text = cli.text("tune --inner-bandwidth 20 --position-share 0.25");
    let words = [
        "position_gain",
        "Kaw",
        "%/(deg/s)",
        "gain margin",
        "phase margin",
        "delay margin",
        "bandwidth, command to angle",
        "per encoder count",
        "\nactuator simulate board --set position_gain=5 --set ",
    ];
    for word in words {
        assert!(text.contains(word), "{word}\n{text}");
    }
}

#[test]
fn options_are_equivalent_to_settings() {
    let cli = Cli::new();
    let options = "--gain 2 --time-constant 0.05 --inner-bandwidth 40 --position-share 0.3";
    let settings = "--set K=2 --set tau=0.05 --set w=40 --set position_share=0.3";
    assert_eq!(tune(&cli, options), tune(&cli, settings));
}

#[test]
fn of_an_asymmetric_motor_the_greater_gain_is_used() {
    let cli = Cli::new();
    let tuning = tune(&cli, "--preset as-measured --inner-bandwidth 35");
    // 35/3.50, and 54/s as the zero of the PI.
    assert!((number(&tuning, "/gains/integral_gain") - 10.0).abs() < 1e-9);
    assert!((number(&tuning, "/gains/anti_windup_gain") - 54.0).abs() < 1e-9);
    // The motor is still that of the preset.
    let command = simulate_command(&tuning);
    assert!(
        command.starts_with("board --preset as-measured --set "),
        "{command}"
    );
    assert!(!command.contains("motor"), "{command}");
    cli.trace(&format!("{command} --duration 0.1"));
}

#[test]
fn other_parameters_of_the_board_are_combined_with_the_gains() {
    let cli = Cli::new();
    let tuning = tune(&cli, "--set rate_filter=0.2 --set Kff=0.3");
    let command = simulate_command(&tuning);
    assert!(command.contains("--set rate_filter=0.2"), "{command}");
    assert!(command.contains("--set feed_forward_gain=0.3"), "{command}");
    // A board with another control period cannot be simulated.
    assert_eq!(
        tune(&cli, "--set control_period_s=0.002")["simulate"],
        Value::Null
    );
}

#[test]
fn the_bode_plot_shows_both_loops_and_both_margins() {
    let cli = Cli::new();
    cli.actuator("tune --plot bode.svg")
        .assert()
        .success()
        .stderr("plot: bode.svg\n");
    let svg = cli.read("bode.svg");
    roxmltree::Document::parse(&svg).expect("the plot is well-formed");
    for label in [
        "open loop",
        "closed loop",
        "gain margin",
        "phase margin",
        "frequency (Hz)",
    ] {
        assert!(svg.contains(label), "{label}");
    }
    cli.actuator("tune --inner-bandwidth 300 --plot bode.html")
        .assert()
        .success();
    let html = cli.read("bode.html");
    assert!(html.contains("the sampled loop is unstable") && !html.contains("phase margin"));
}
