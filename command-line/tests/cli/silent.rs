//! Requests that cannot be met are refused, not ignored; interrupts leave nothing half done.

use super::{Cli, served::Served};

#[test]
fn a_parameter_file_without_a_parameter_is_refused() {
    let cli = Cli::new();
    for content in ["", "model = \"black-box-1\"\n", "[set]\n"] {
        cli.write("empty.toml", content);
        for command in ["experiment black-box-1", "simulate black-box-1 --csv -"] {
            let arguments = format!("{command} --parameters empty.toml");
            cli.assert_error(&arguments, 2, "empty.toml sets no parameter, expected");
        }
    }
}

#[test]
fn a_bus_that_is_overloaded_is_an_error() {
    let cli = Cli::new();
    for more in ["", " --json"] {
        let run = cli
            .actuator(&format!("busload --actuators 20{more}"))
            .assert()
            .code(2);
        let error = String::from_utf8_lossy(&run.get_output().stderr).into_owned();
        // 20 x 78.5 kbit/s of 1 Mbit/s.
        let message = "20 actuators may load the bus by 157.0 %, expected 12 actuators at the most";
        assert!(error.contains(message), "{error}");
        assert!(!run.get_output().stdout.is_empty());
    }
}

#[test]
fn an_angle_beyond_the_limits_has_a_status_of_its_own() {
    let served = Served::new(&[]);
    served.text("set 6081=200000 607D:2=8000");
    let error = served.error("move 500 --within 20", 4);
    assert!(
        error.contains("deg: the angle is beyond the limits 607Dh"),
        "{error}"
    );
}

/// The exit status with standard output and standard error redirected by this shell text.
#[cfg(target_os = "linux")]
fn status(cli: &Cli, arguments: &str, redirected: &str) -> Option<i32> {
    let program = assert_cmd::cargo::cargo_bin!("actuator")
        .display()
        .to_string();
    let text = format!("'{program}' {arguments} {redirected}");
    let mut shell = std::process::Command::new("bash");
    let run = shell
        .args(["-o", "pipefail", "-c", &text])
        .current_dir(cli.path("."));
    run.status().expect("a shell").code()
}

#[cfg(target_os = "linux")]
#[test]
fn output_that_cannot_be_written_ends_with_1_and_without_a_panic() {
    let cli = Cli::new();
    let run = "simulate board --duration 0.1 --csv";
    for (arguments, redirected) in [
        ("identify nofile", "2>/dev/full"),
        ("simulate nomodel", "2>/dev/full"),
        // A warning, and the name of the file that is written.
        (
            "simulate grey-box --preset as-printed-strict --duration 0.1 --csv -",
            "2>/dev/full >out",
        ),
        ("report --out page.html", "2>/dev/full >out"),
        ("--help", ">/dev/full"),
        ("scan --bus 127.0.0.1:1", "2>&1 | true"),
        (&format!("{run} -"), ">/dev/full 2>errors"),
        // More than a pipe holds.
        (
            "simulate board --duration 1 --csv - --every 1",
            "2>errors | true",
        ),
    ] {
        assert_eq!(
            status(&cli, arguments, redirected),
            Some(1),
            "{arguments} {redirected}"
        );
    }
    assert_eq!(cli.read("errors"), "", "the reader of a pipe may close it");
    assert_eq!(
        status(&cli, &format!("{run} -"), "2>/dev/full >out"),
        Some(0),
        "nothing to report"
    );
    // Closed from the start, as by a daemon: they are replaced by /dev/null.
    assert_eq!(
        status(&cli, "simulate board --duration 0.1", "2>&- >&-"),
        Some(0)
    );
}

/// Starts the program with the default reactions to signals, ends it once it has written to
/// `file`, and returns its exit status.
#[cfg(target_os = "linux")]
fn ended_at_work(cli: &Cli, arguments: &str, file: &str, signal: &str) -> Option<i32> {
    use std::process::Command;

    // A test that was started in the background has interrupts ignored.
    let mut run = Command::new("env")
        .arg("--default-signal=INT,HUP,TERM")
        .arg(assert_cmd::cargo::cargo_bin!("actuator"))
        .args(arguments.split(' '))
        .current_dir(cli.path("."))
        .spawn()
        .expect("the program starts");
    let half = cli.path(file);
    let begun = || std::fs::metadata(&half).is_ok_and(|file| file.len() > 0);
    while !begun() && run.try_wait().expect("it is a child").is_none() {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let pid = run.id().to_string();
    let sent = Command::new("kill").args([signal, &pid]).status();
    assert!(sent.is_ok_and(|status| status.success()));
    run.wait().expect("it ends").code()
}

#[cfg(target_os = "linux")]
#[test]
fn an_interrupted_run_leaves_the_old_files_and_no_others() {
    for signal in ["-INT", "-TERM", "-HUP"] {
        let cli = Cli::new();
        cli.write("run.csv", "old\n");
        let run = "simulate board --duration 1e6 --every 1 --csv run.csv --out run.mat";
        // A MAT file takes fewer rows.
        let run = run.replace("1e6 --every 1", "1e6 --every 2000");
        assert_eq!(ended_at_work(&cli, &run, "run.csv.part", signal), Some(130));
        assert_eq!(cli.read("run.csv"), "old\n");
        let files = std::fs::read_dir(cli.path(".")).expect("the folder");
        assert_eq!(files.count(), 1, "{signal}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn an_interrupted_recording_has_all_samples_until_then() {
    let served = Served::new(&[]);
    let run = format!("record --for 60 --out run.csv --bus {}", served.bus);
    assert_eq!(ended_at_work(&served.cli, &run, "run.csv", "-INT"), Some(0));
    let text = served.cli.read("run.csv");
    let mut lines = text.lines();
    let columns = lines.next().expect("a header").split(',').count();
    assert!(text.ends_with('\n') && lines.clone().count() > 0);
    assert!(lines.all(|line| line.split(',').count() == columns));
}
