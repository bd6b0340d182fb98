//! Options of `actuator identify`, `compare` and `experiment` that cannot be had, and what is said
//! of them.

use super::Desk;

/// A desk with a recording of black box 1 on a pulse, `pulse.csv`.
fn desk() -> Desk {
    let desk = Desk::new();
    desk.text("simulate black-box-1 --input pulse --every 80 --csv pulse.csv");
    desk
}

#[test]
fn what_is_known_of_a_run_is_a_parameter_of_a_model_that_is_fitted() {
    let desk = desk();
    let identify = "identify pulse.csv --model black-box-1 --starts 1";
    for (known, message) in [
        ("nonsense=0.5", "unknown parameter `nonsense`"),
        ("pole_rad=30", "did you mean `pole_rad_s`?"),
        ("pendulum_mass_kg=0.5", "expected delay_s, gain, "),
    ] {
        desk.assert_error(&format!("{identify} --known {known}"), 2, message);
    }
    desk.assert_error(
        "compare pulse.csv --starts 1 --known pendulum_mas_kg=5",
        2,
        "unknown parameter `pendulum_mas_kg`",
    );
    let text = desk.text(&format!("{identify} --known pole_rad_s=29 --json -"));
    let document: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let parameters = document["models"][0]["parameters"].as_array();
    let is_pole = |p: &serde_json::Value| p["name"] == "pole_rad_s" && p["estimate"] != 29.0;
    assert!(!parameters.expect("a list").iter().any(is_pole), "{text}");
}

#[test]
fn options_that_exclude_each_other_are_refused_by_both_names() {
    let desk = desk();
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
        desk.assert_error(&command, 2, message);
    }
    desk.assert_error(
        "experiment black-box-1 --fix pole_rad_s --free pole_rad_s",
        2,
        "--fix and --free both name pole_rad_s",
    );
    desk.text(
        "identify pulse.csv --model black-box-1 --starts 1 --fix gain=1 --bound pole_rad_s=5:80 \
         --start pole_rad_s=20 --share delay_s",
    );
}

#[test]
fn a_bound_or_value_that_cannot_be_says_what_is_wrong_with_it() {
    let desk = desk();
    for (option, message) in [
        (
            "--bound pole_rad_s=30:10",
            "30:10, expected the lower bound before a greater one",
        ),
        (
            "--bound pole_rad_s=30:30",
            "30:30, expected the lower bound before a greater one",
        ),
        (
            "--bound pole_rad_s=nan:30",
            "expected the lower bound before a greater one",
        ),
        (
            "--bound pole_rad_s=-10:-1",
            "-10:-1, expected bounds within its range, ",
        ),
        (
            "--fix pole_rad_s=inf",
            "pole_rad_s is held at inf, expected ",
        ),
        ("--fix pole_rad_s=-3", "pole_rad_s is held at -3, expected "),
    ] {
        let command = format!("identify pulse.csv --model black-box-1 --starts 1 {option}");
        desk.assert_error(&command, 2, message);
    }
}

#[test]
fn an_experiment_expects_the_parameters_of_its_own_model() {
    let desk = desk();
    desk.text("identify pulse.csv --model black-box-1 --starts 1 --parameters one.toml");
    desk.assert_error(
        "experiment black-box-2 --parameters one.toml",
        2,
        "one.toml has the parameters of black-box-1, expected those of black-box-2",
    );
    desk.text("experiment black-box-1 --parameters one.toml --input doublet");
}

#[test]
fn the_file_of_the_oscillator_comes_back_as_its_frequency_and_damping() {
    let desk = Desk::new();
    desk.write(
        "two.toml",
        "model = \"black-box-2\"\n[set]\nposition_gain_per_s2 = 400.0\nrate_gain_per_s = 30.0\n",
    );
    let text =
        desk.text("experiment black-box-2-oscillator --parameters two.toml --input doublet --json");
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
    let desk = Desk::new();
    let message = "motor-m1 takes the duty of its motor, expected one of black-box-1,";
    desk.assert_error("experiment motor-m1", 2, message);
}

#[test]
fn results_that_could_not_be_written_are_refused_before_the_work() {
    let desk = desk();
    for (outputs, status, message) in [
        (
            "--json both --html ./both",
            2,
            "--json and --html both write ./both",
        ),
        (
            "--html page --parameters page",
            2,
            "--html and --parameters both write page",
        ),
        ("--html none/page.html", 1, "cannot write none/page.html"),
        ("--json .", 1, "cannot write ."),
    ] {
        // A recording that is not there would be noticed next.
        let command = format!("identify missing.csv --model black-box-1 {outputs}");
        desk.assert_error(&command, status, message);
    }
    desk.assert_error("compare missing.csv --html a --json a", 2, "both write a");
    desk.assert_error(
        "experiment black-box-1 --csv none/a.csv",
        1,
        "cannot write none/a.csv",
    );
    let left = std::fs::read_dir(desk.path(".")).expect("the folder");
    assert_eq!(left.count(), 1, "nothing but the recording");
}
