//! `actuator mujoco`.

use predicates::{prelude::*, str::contains};

use super::Cli;

#[test]
fn a_parameter_file_becomes_a_servo_with_its_parameters_alone() {
    let cli = Cli::new();
    cli.write(
        "fitted.toml",
        "model = \"board\"\nplant = \"bench\"\n[set]\nsupply_v = 4.8\nbacklash_deg = 0.3\n",
    );
    cli.actuator("mujoco --parameters fitted.toml --set P=9 --name elbow --joint j3 --out e.xml")
        .assert()
        .success();
    let text = std::fs::read_to_string(cli.path("e.xml")).expect("the file is there");
    let parameters = text.split("key=\"parameters\" value=\"").nth(1).unwrap();
    let parameters = parameters.split('"').next().unwrap();
    let mut words: Vec<_> = parameters.split(' ').collect();
    words.sort_unstable();
    assert_eq!(
        words,
        [
            "0.3",
            "4.8",
            "9.0",
            "backlash_deg",
            "position_gain",
            "supply_v"
        ]
    );
    assert!(text.contains("name=\"elbow\" joint=\"j3\""));
}

#[test]
fn what_cannot_be_simulated_is_refused() {
    let cli = Cli::new();
    for (options, expected) in [
        ("--model grey-box --plant bench", "`grey-box` has no plant"),
        ("--set P=-1", "position_gain is -1"),
        ("--name a\"b", "expected letters"),
        ("--parameters nowhere.toml", "nowhere.toml"),
    ] {
        cli.actuator(&format!("mujoco {options}"))
            .assert()
            .failure()
            .stderr(contains(expected))
            .stdout(predicate::str::is_empty());
    }
}
