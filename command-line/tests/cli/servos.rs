//! `actuator serve --protocol`: servos on a serial bus.

use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use crate::Cli;
use crate::served::Served;

/// What a client of the bus gets as the answer to these bytes.
fn exchange(stream: &mut TcpStream, bytes: &[u8], answer: usize) -> Vec<u8> {
    stream.write_all(bytes).expect("it is sent");
    let mut answered = vec![0; answer];
    stream.read_exact(&mut answered).expect("an answer");
    answered
}

fn connect(served: &Served) -> TcpStream {
    let stream = TcpStream::connect(&served.bus).expect("it accepts");
    let timeout = Some(Duration::from_secs(10));
    stream.set_read_timeout(timeout).expect("a time");
    stream
}

#[test]
fn the_clients_of_a_port_share_the_servos() {
    let served = Served::new(&["--protocol", "sts3215", "--nodes", "2"]);
    let [mut one, mut other] = [connect(&served), connect(&served)];
    // The manual's ping, and one of the second servo.
    let ping = [0xFF, 0xFF, 1, 2, 1, 0xFB];
    assert_eq!(exchange(&mut one, &ping, 6), [0xFF, 0xFF, 1, 2, 0, 0xFC]);
    let ping = [0xFF, 0xFF, 2, 2, 1, 0xFA];
    assert_eq!(exchange(&mut other, &ping, 6), [0xFF, 0xFF, 2, 2, 0, 0xFB]);
    // What one writes, the other reads: P of the first servo.
    exchange(&mut one, &[0xFF, 0xFF, 1, 4, 3, 0x15, 16, 0xD2], 6);
    let read = [0xFF, 0xFF, 1, 4, 2, 0x15, 1, 0xE2];
    assert_eq!(exchange(&mut other, &read, 7)[5], 16);
    drop(one);
    assert_eq!(exchange(&mut other, &read, 7)[5], 16);
}

#[test]
fn a_part_of_a_packet_is_forgotten_after_a_pause() {
    let served = Served::new(&["--protocol", "xl330-m288"]);
    let mut stream = connect(&served);
    // The begin of a packet of 255 bytes more.
    stream
        .write_all(&[0xFF, 0xFF, 0xFD, 0, 1, 0xFF, 0])
        .expect("it is sent");
    std::thread::sleep(Duration::from_millis(200));
    let ping = [0xFF, 0xFF, 0xFD, 0, 1, 3, 0, 1, 0x19, 0x4E];
    let answer = exchange(&mut stream, &ping, 14);
    assert_eq!(answer[9..12], [0xB0, 4, 46]);
}

#[test]
fn faults_of_a_file_act_and_others_are_reported() {
    let cli = Cli::new();
    std::fs::write(cli.path("faults"), "2 vanish\n1 bend\n1 corrupt 1\n").expect("a file");
    let file = cli.path("faults").display().to_string();
    let served = Served::new(&[
        "--protocol",
        "sts3215",
        "--nodes",
        "2",
        "--servo-faults",
        &file,
    ]);
    // Faults act within 10 ms of the server's start.
    std::thread::sleep(Duration::from_millis(300));
    let mut stream = connect(&served);
    let pings = [0xFF, 0xFF, 2, 2, 1, 0xFA, 0xFF, 0xFF, 1, 2, 1, 0xFB];
    assert_eq!(
        exchange(&mut stream, &pings, 6),
        [0xFF, 0xFF, 1, 2, 0, 0xFD]
    );
    let notices = std::fs::read_to_string(served.cli.path("notices")).expect("a file");
    assert!(
        notices.contains("fault `1 bend`: expected `supply VOLTS`"),
        "{notices}"
    );
}

#[test]
fn options_that_cannot_be_are_refused() {
    let cli = Cli::new();
    std::fs::write(cli.path("file"), "a file").expect("a file");
    for (options, status, message) in [
        (
            "--protocol sts3216",
            2,
            "sts3215, sts3250, xl330-m288, xm430-w350",
        ),
        (
            "--protocol sts3215 --supply-ohm=-1",
            2,
            "--supply-ohm is -1, expected 0 to 100 ohm",
        ),
        ("--supply-ohm 1", 2, "--protocol <PROTOCOL>"),
        ("--load 0.2", 2, "'--load <[ID@]KG:M>': expected [ID@]KG:M"),
        ("--load a@0.2:0.1", 2, "`a` is not an ID"),
        ("--load 0.2:a", 2, "`a` is not a number"),
        (
            "--load 2@20:0.1",
            2,
            "pendulum_mass_kg is 20, expected a number from 0 to 10 kg",
        ),
        (
            "--protocol sts3215 --nodes 2 --load 3@0.2:0.1",
            2,
            "--load 3@: expected an ID from 1 to 2",
        ),
        (
            "--protocol sts3215 --seed 1",
            2,
            "--seed concerns actuators",
        ),
        (
            "--protocol sts3215 --elf a.elf --nodes 7",
            2,
            "--nodes is 7, expected 1 to 6 emulated boards",
        ),
        (
            "--protocol sts3215 --elf a.elf --supply-ohm 1",
            2,
            "--supply-ohm concerns simulated servos",
        ),
        (
            "--protocol sts3215 --elf a.elf --comm-elf b.elf",
            2,
            "--comm-elf belongs to a CAN bus",
        ),
        ("--elf a.elf", 2, "--elf needs --comm-elf"),
        #[cfg(unix)]
        (
            "--protocol sts3215 --pty --link file",
            1,
            "cannot serve at file: File exists",
        ),
    ] {
        cli.assert_error(&format!("serve {options}"), status, message);
    }
    let kept = std::fs::read_to_string(cli.path("file")).expect("a file");
    assert_eq!(kept, "a file");
}

#[test]
fn the_current_that_holds_a_pendulum_is_that_of_its_weight_within_the_friction() {
    let load = "2@1.13:0.12";
    let served = Served::new(&["--protocol", "sts3250", "--nodes", "2", "--load", load]);
    let hold = |id: u8| -> f64 {
        let text = |arguments: &str| {
            let bus = format!("--bus sts:{} --node {id}", served.bus);
            served.cli.text(&format!("{arguments} {bus}"))
        };
        // 90 deg: the last 0.7 deg are within the friction.
        text("set goal_position=3072");
        std::thread::sleep(Duration::from_secs(2));
        let current = text("get present_current");
        let current = current.split_whitespace().next().map(str::parse);
        current.and_then(Result::ok).expect("a number")
    };
    // Currents of 6.5 mA; 1.45 Nm/A, and 0.258 Nm of friction, which holds in either direction.
    let of_torque = |nm: f64| nm / 1.45 / 6.5e-3;
    let (weight, friction) = (of_torque(1.13 * 9.80665 * 0.12), of_torque(0.258));
    let (free, loaded) = (hold(1), hold(2));
    assert!(free.abs() <= friction + 1.0, "{free}");
    assert!(
        (loaded - weight).abs() <= friction + 1.0,
        "{loaded}, {weight}"
    );
}

#[test]
fn servos_are_found_set_moved_and_recorded_with_columns_that_identify_reads() {
    for (model, prefix, register, default) in [
        ("sts3215", "sts", "p-coefficient", "32"),
        ("xm430-w350", "dxl", "position_p_gain", "800"),
    ] {
        let served = Served::new(&["--protocol", model, "--nodes", "2"]);
        let bus = format!("--bus {prefix}:{}", served.bus);
        let text = |arguments: &str| served.cli.text(&format!("{arguments} {bus}"));
        let error = |arguments: &str, status: i32, message: &str| {
            served
                .cli
                .assert_error(&format!("{arguments} {bus}"), status, message);
        };
        let found: serde_json::Value = serde_json::from_str(&text("scan --json")).expect("JSON");
        let expected = [1, 2].map(|id| serde_json::json!({ "id": id, "model": model }));
        assert_eq!(found, serde_json::json!(expected));
        let read = format!("get {register} --node 2");
        assert!(text(&read).starts_with(default), "{}", text(&read));
        text(&format!("set {register}=100 --node 2"));
        assert!(text(&read).starts_with("100"));
        error("set present_position=1", 2, "present_position is read only");
        let range = match prefix {
            "sts" => "expected -32767 to 32767 in units of 0.088 deg",
            _ => "expected -1048575 to 1048575 in units of 0.088 deg",
        };
        error("set goal_position=1048576", 2, range);
        assert!(text("get goal_position").ends_with(" in units of 0.088 deg\n"));
        assert_eq!(text("get id"), "1\n");
        error("get goal-positon", 2, "did you mean `goal_position`?");
        error("get goal_position --node 9", 1, "servo 9 does not answer");
        error(
            "faults",
            2,
            "servos have the commands scan, get, set, move, stop, monitor and record",
        );
        let moved: serde_json::Value = serde_json::from_str(&text("move 30 --json")).expect("JSON");
        assert!(
            (moved["angle_deg"].as_f64().expect("a number") - 30.0).abs() < 1.0,
            "{moved}"
        );
        // Too late: it stops where it is.
        error(
            "move -150 --within 0.1",
            1,
            "expected -150 deg to be reached",
        );
        let goal: f64 = text("get goal_position")
            .split(' ')
            .next()
            .and_then(|n| n.parse().ok())
            .expect("a number");
        assert!(goal > 1000.0, "{goal}");
        text("stop");
        assert!(text("get torque_enable").starts_with('0'));
        let recorded = served.cli.path("servo.csv").display().to_string();
        text("move -45");
        let shown = text("monitor --for 0.3");
        assert!(
            shown.contains("angle -4") && shown.contains("torque on, 2"),
            "{shown}"
        );
        let lines = text("monitor --for 0.3 --json");
        let line: serde_json::Value =
            serde_json::from_str(lines.lines().next().expect("a line")).expect("JSON");
        let angle = line["angle_deg"].as_f64().expect("a number");
        assert!((angle + 45.0).abs() < 1.0, "{line}");
        text("set goal_position=1000");
        text(&format!("record --for 1 --out {recorded}"));
        let trace = crate::Csv::parse(&served.cli.read("servo.csv"));
        assert!(trace.rows.len() > 50, "{} rows", trace.rows.len());
        let (angle, command) = (trace.column("angle_deg"), trace.column("command_deg"));
        assert!(
            command
                .iter()
                .all(|deg| (deg - (1000.0 - 2048.0) * 360.0 / 4096.0).abs() < 1e-9)
        );
        assert!(
            angle[0] > -70.0 && angle[angle.len() - 1] < -85.0,
            "{angle:?}"
        );
        let supply = trace.column("supply_mv")[0];
        assert!(
            supply == if prefix == "sts" { 7400.0 } else { 12_000.0 },
            "{supply}"
        );
    }
}

#[test]
fn a_servo_is_halted_in_each_of_its_modes() {
    // The torque is on at the goal of an STS in the mode 3.
    for (model, prefix, mode, goal) in [
        ("sts3215", "sts", 0, "goal_position=4000"),
        ("sts3215", "sts", 1, "goal_velocity=1000"),
        ("sts3215", "sts", 2, "goal_time=500"),
        ("sts3215", "sts", 3, "goal_position=30000"),
        ("xl330-m288", "dxl", 0, "goal_current=300"),
        ("xl330-m288", "dxl", 1, "goal_velocity=100"),
        ("xl330-m288", "dxl", 4, "goal_position=1000000"),
        ("xl330-m288", "dxl", 16, "goal_pwm=300"),
    ] {
        let served = Served::new(&["--protocol", model]);
        let bus = format!("--bus {prefix}:{}", served.bus);
        let text = |arguments: &str| served.cli.text(&format!("{arguments} {bus}"));
        text(&format!("set operating_mode={mode}"));
        text(&format!("set torque_enable=1 {goal}"));
        if !matches!((prefix, mode), ("sts", 0) | (_, 4)) {
            served.cli.assert_error(
                &format!("move 10 {bus}"),
                2,
                &format!("servo 1 has operating_mode {mode}, expected one with angles: "),
            );
        }
        text("stop --hold");
        let rate = || -> f64 {
            let rate = text("get present_velocity");
            let rate = rate.split_whitespace().next().map(str::parse);
            rate.and_then(Result::ok).expect("a number")
        };
        // Each takes less than 1 s; a processor that others use delays the servo's time.
        let end = Instant::now() + Duration::from_secs(20);
        while (0..3).any(|_| rate().abs() >= 3.0) {
            assert!(Instant::now() < end, "{model}, mode {mode}: {}", rate());
        }
        assert!(text("get torque_enable").starts_with('1'));
    }
}

#[test]
fn a_client_that_floods_the_bus_does_not_keep_the_others_from_it() {
    let served = Served::new(&["--protocol", "sts3215"]);
    let mut flood = connect(&served);
    // Bytes that begin no packet, faster than the line takes them, until the server ends.
    let flooding = std::thread::spawn(move || while flood.write_all(&[0; 4096]).is_ok() {});
    std::thread::sleep(Duration::from_millis(200));
    let ping = [0xFF, 0xFF, 1, 2, 1, 0xFB];
    let answer = exchange(&mut connect(&served), &ping, 6);
    assert_eq!(answer, [0xFF, 0xFF, 1, 2, 0, 0xFC]);
    drop(served);
    flooding.join().expect("it ends");
}
