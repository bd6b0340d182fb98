//! `actuator export`.

use predicates::{prelude::*, str::contains};

use super::Cli;

#[test]
fn a_parameter_file_becomes_the_actuator_of_a_simulator() {
    let cli = Cli::new();
    cli.write(
        "fitted.toml",
        "model = \"black-box-1\"\n[set]\npole_rad_s = 17.0\nrate_limit_up_deg_s = 1e5\n\
         rate_limit_down_deg_s = 1e5\ndelay_s = 0.0125\n",
    );
    cli.actuator("export fitted.toml --to matlab --out servo.m")
        .assert()
        .success()
        .stdout(contains("deg rms from the model on variable-step"));
    let text = cli.read("servo.m");
    assert!(
        text.contains("tf(17, [1, 17], 'InputDelay', 0.0125)"),
        "{text}"
    );
}

#[test]
fn what_cannot_be_exported_is_refused() {
    let cli = Cli::new();
    for (options, expected) in [
        ("", "--to <TARGET>"),
        ("--to mujoco", "mujoco-position"),
        ("--to bam --step 1", "the period is 1 s"),
        (
            "--to matlab --model black-box-1 --input variable-step",
            "matlab cannot represent this model",
        ),
    ] {
        cli.actuator(&format!("export {options}"))
            .assert()
            .failure()
            .code(2)
            .stderr(contains(expected))
            .stdout(predicate::str::is_empty());
    }
}

#[test]
fn without_a_command_the_program_says_what_to_begin_with() {
    let cli = Cli::new();
    let first = cli.text("");
    for line in first.lines().filter(|line| line.starts_with("  actuator")) {
        let command = line.split_whitespace().nth(1).expect("a command");
        cli.actuator(&format!("{command} --help"))
            .assert()
            .success();
    }
    assert!(first.contains("actuator studio"), "{first}");
}
