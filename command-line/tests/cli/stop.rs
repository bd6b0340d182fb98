//! An actuator stops when the command that moves it ends.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::Duration;

use crate::served::Served;

/// A slow motion to 90 deg, or an excitation of the same rate.
const MOTIONS: [&str; 2] = [
    "move 90 --rate 20",
    "excite sine --amplitude 20 --start 0.3 --repetitions 20",
];

/// A command at the server, with its output closed.
fn spawn(served: &Served, arguments: &str) -> Child {
    Command::new(assert_cmd::cargo::cargo_bin!("actuator"))
        .args(arguments.split(' '))
        .args(["--bus", &served.bus])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("it starts")
}

fn angle_deg(served: &Served) -> f64 {
    let text = served.text("get 6064");
    let number = text.split_whitespace().next().expect("a word");
    number.parse::<f64>().expect("a number") / 1000.0
}

/// Whether the shaft moves by more than 1 deg within half a second.
fn moves(served: &Served) -> bool {
    let before = angle_deg(served);
    thread::sleep(Duration::from_millis(500));
    (angle_deg(served) - before).abs() > 1.0
}

/// A signal ends the program that moves the actuator.
fn interrupt(motion: &str, signal: &str) {
    let served = Served::new(&[]);
    let mut program = spawn(&served, motion);
    thread::sleep(Duration::from_millis(1500));
    assert!(moves(&served), "{motion}");
    let pid = program.id().to_string();
    let killed = Command::new("kill").args(["-s", signal, &pid]).status();
    assert!(killed.expect("kill").success());
    let status = program.wait().expect("it ends");
    if signal != "KILL" {
        assert_eq!(status.code(), Some(130), "{motion}, {signal}");
    }
    // 300 ms until the heartbeat is missed, and the stop.
    thread::sleep(Duration::from_millis(500));
    assert!(!moves(&served), "{motion}, {signal}");
}

/// At once for all signals, since each waits most of the time.
#[test]
fn the_actuator_stops_when_the_program_is_interrupted_or_killed() {
    for motion in MOTIONS {
        thread::scope(|scope| {
            for signal in ["INT", "TERM", "HUP", "KILL"] {
                scope.spawn(move || interrupt(motion, signal));
            }
        });
    }
}

#[test]
fn a_move_that_is_not_awaited_goes_on_and_stop_ends_it() {
    let served = Served::new(&[]);
    served.text("move 90 --rate 20 --no-wait");
    thread::sleep(Duration::from_millis(300));
    assert!(moves(&served));
    served.text("stop --hold");
    assert!(!moves(&served));
    served.text("move -90 --rate 20 --no-wait");
    thread::sleep(Duration::from_millis(300));
    assert!(moves(&served));
    served.text("stop");
    assert!(!moves(&served));
}

#[test]
fn a_move_that_takes_too_long_is_halted() {
    let served = Served::new(&[]);
    let error = served.error("move 90 --rate 20 --within 1", 3);
    assert!(
        error.contains("expected the angle to be reached"),
        "{error}"
    );
    assert!(!moves(&served));
}

/// Interrupts a commissioning in its runs; the shaft stops, and the objects are those of before.
fn interrupt_commissioning(served: &Served, arguments: &str, begin: impl FnOnce()) {
    let objects = [
        "get 607D:1",
        "get 607D:2",
        "get 6072",
        "get 6080",
        "get 6081",
        "get 2011:2",
    ];
    let before = objects.map(|object| served.text(object));
    let mut program = spawn(served, arguments);
    begin();
    // It is in its runs, which begin after 5 s and end after 18 s, with all objects changed.
    // Another client of the one SDO server of the actuator would end the upload of a recording.
    thread::sleep(Duration::from_secs(8));
    assert!(program.try_wait().expect("a state").is_none());
    let pid = program.id().to_string();
    let killed = Command::new("kill").args(["-s", "TERM", &pid]).status();
    assert!(killed.expect("kill").success());
    assert_eq!(program.wait().expect("it ends").code(), Some(130));
    assert!(!moves(served));
    assert_eq!(objects.map(|object| served.text(object)), before);
}

#[test]
fn an_interrupted_commissioning_stops_the_shaft_and_restores_the_objects() {
    let served = Served::new(&[]);
    interrupt_commissioning(&served, "commission --range -45 45", || {});
}

#[test]
fn an_interrupted_request_is_answered_as_refused() {
    let served = Served::new(&[]);
    interrupt_commissioning(&served, "commission --range -45 45 --on-request", || {
        // At its start it refuses requests of before. It begins with steps that are no upload.
        let runs = |_| {
            served.text("set 2055=1");
            thread::sleep(Duration::from_millis(300));
            served.text("get 2055").starts_with('2')
        };
        assert!((0..50).any(runs));
    });
    assert!(served.text("get 2055").starts_with('4'));
}

/// The shaft is at 0 deg, outside the range: the first step refuses.
#[test]
fn each_request_of_a_master_is_answered_and_the_program_waits_for_the_next() {
    let served = Served::new(&[]);
    // A run whose program has ended.
    served.text("set 2055=2");
    let mut program = spawn(&served, "commission --range 100 190 --on-request");
    // The run of before has failed; each request is refused by step 1.
    for answer in ["4", "17", "17"] {
        if answer == "17" {
            served.text("set 2055=1");
        }
        let is_answered = |_| {
            thread::sleep(Duration::from_millis(100));
            served.text("get 2055").trim_end() == answer
        };
        assert!((0..100).any(is_answered), "{answer}");
    }
    assert!(program.try_wait().expect("a state").is_none());
    let pid = program.id().to_string();
    let killed = Command::new("kill").args(["-s", "TERM", &pid]).status();
    assert!(killed.expect("kill").success());
    assert_eq!(program.wait().expect("it ends").code(), Some(0));
}

#[test]
fn a_requested_commissioning_is_saved_with_its_date() {
    let served = Served::new(&[]);
    let mut program = Command::new(assert_cmd::cargo::cargo_bin!("actuator"))
        .args("commission --range -45 45 --on-request --no-tuning --bus".split(' '))
        .arg(&served.bus)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("it starts");
    // It has refused requests of before.
    thread::sleep(Duration::from_millis(500));
    served.text("set 2055=1");
    // A read of the object would end the upload of a recording: the program prints what it saved.
    let lines = BufReader::new(program.stdout.take().expect("its output")).lines();
    let mut lines = lines.map_while(Result::ok);
    assert!(lines.any(|line| line.starts_with("Written and saved")));
    // It is answered before it is printed.
    assert!(served.text("get 2055").starts_with('3'));
    assert!(!served.text("get 1020:1").starts_with("0"));
    program.kill().expect("it waits");
    program.wait().expect("it ends");
}

#[test]
fn the_middle_of_a_range_becomes_position_0() {
    let served = Served::new(&[]);
    let text = served.text("commission --range -30 20 --centre --no-tuning");
    assert!(text.contains("2041:3"), "{text}");
    let [origin, low, high] = ["2041:3", "607D:1", "607D:2"].map(|object| {
        let text = served.text(&format!("get {object}"));
        let number = text.split_whitespace().next().map(str::parse::<i32>);
        number.expect("a value").expect("mdeg")
    });
    // Two counts of the encoder.
    assert!((origin - 5_000).abs() <= 176, "{origin}");
    assert_eq!((low, high), (origin - 30_000, origin + 20_000));
}

/// The second request would be one of other positions.
#[test]
fn requests_do_not_centre_a_given_range() {
    let output = Command::new(assert_cmd::cargo::cargo_bin!("actuator"))
        .args("commission --range -45 45 --centre --on-request --bus 127.0.0.1:1".split(' '))
        .output()
        .expect("it starts");
    assert_eq!(output.status.code(), Some(2));
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(error.contains("expected no --range"), "{error}");
}
