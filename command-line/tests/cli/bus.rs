//! Actuators on a virtual bus, and the commands that access them.

use std::io::{BufRead, BufReader, Read};
use std::process::{Command, Stdio};

use crate::Cli;
use crate::identify::json;
use crate::served::Served;

#[test]
fn two_actuators_are_found_moved_and_read() {
    let served = Served::new(&["--nodes", "2"]);
    let devices: serde_json::Value =
        serde_json::from_str(&served.text("scan --json")).expect("JSON");
    assert_eq!(devices[1]["node"], 2);
    assert_eq!(devices[1]["serial"], 2);
    served.text("move --node 2 15");
    let angle: f64 = served
        .text("get --node 2 position-actual-value")
        .trim_end_matches(" mdeg\n")
        .parse()
        .expect("a number");
    // The position window.
    assert!((angle - 15_000.0).abs() <= 500.0, "{angle}");
    assert_eq!(served.text("get 6064"), "0 mdeg\n", "the other one");
}

#[test]
fn values_are_stored_and_restored() {
    let served = Served::new(&[]);
    served.text("set profile-velocity=123000 60FB:1=9.5");
    served.text("save");
    served.text("set 6081=1");
    served.text("restore --group communication --reset");
    assert_eq!(served.text("get 6081"), "123000 mdeg/s\n");
    assert_eq!(served.text("get 60FB:1"), "9.5 1/s\n");
}

#[test]
fn a_fitted_motor_is_written_to_the_motor_model_of_the_board() {
    let served = Served::new(&[]);
    let cli = &served.cli;
    cli.text("simulate board --plant bench --every 80 --csv run.csv");
    cli.text(
        "identify run.csv --model motor-m1 --fix winding_resistance_ohm=7.7 --fix supply_v=6 \
         --fix torque_constant_nm_a=1.16 --starts 1 --parameters fitted.toml",
    );
    let fitted: toml::Table = cli.read("fitted.toml").parse().expect("TOML");
    let fitted = |name: &str| fitted["set"][name].as_float().expect("a number");
    let of_the_board = |object: &str| -> f64 {
        let text = served.text(&format!("get {object}"));
        let number = text.split(' ').next().expect("a number");
        number.trim_end().parse().expect("a number")
    };
    served.text("set --parameters fitted.toml model-selection=1");
    let ratio = fitted("gear_ratio");
    let at_the_output = fitted("motor_inertia_kg_m2") * ratio * ratio;
    for (object, expected) in [
        ("2011:1", 7.7),
        ("2011:2", fitted("torque_constant_nm_a")),
        ("2011:3", ratio),
        ("2011:4", at_the_output),
        ("2011:5", fitted("viscous_friction_nm_s_deg").to_degrees()),
        ("2011:6", fitted("coulomb_friction_nm")),
        ("2010:2", 1.0),
    ] {
        let value = of_the_board(object);
        // The objects are REAL32; the horn of the bench plant has an inertia of 2e-6 kg m^2.
        let near = 1e-6 * expected + if object == "2011:4" { 2.1e-6 } else { 1e-12 };
        assert!(
            (value - expected).abs() <= near,
            "{object}: {value} {expected}"
        );
    }
    // What a fit does not determine is not written.
    let text = cli.read("fitted.toml");
    let all = text.replace(
        "undetermined = [",
        "undetermined = [\"motor_inertia_kg_m2\", ",
    );
    let open = all.replace("motor_inertia_kg_m2 = ", "motor_inertia_kg_m2 = 1");
    cli.write("open.toml", &open);
    served.text("set 2011:6=0.001");
    let before = of_the_board("2011:4");
    served.text("set --parameters open.toml");
    assert_eq!(of_the_board("2011:4"), before);
    assert!((of_the_board("2011:6") / fitted("coulomb_friction_nm") - 1.0).abs() < 1e-6);
    cli.text("simulate black-box-1 --every 80 --csv simple.csv");
    cli.text("identify simple.csv --model black-box-1 --starts 1 --parameters simple.toml");
    let error = served.error("set --parameters simple.toml", 2);
    assert!(error.contains("black-box-1"), "{error}");
}

#[test]
fn a_refused_request_ends_with_a_reason_and_its_status() {
    let served = Served::new(&[]);
    assert!(
        served
            .error("set 607D:1=60001", 3)
            .contains("below the minimum")
    );
    assert!(
        served
            .error("get 6064 --node 7", 1)
            .contains("node 7 does not answer")
    );
    assert!(
        served
            .error("get statuswort", 2)
            .contains("did you mean `statusword`")
    );
    assert!(served.error("set 6041=1", 2).contains("read only"));
    assert!(served.error("set 6040", 2).contains("OBJECT=VALUE"));
    assert!(served.error("record --capture", 3).contains("no data"));
    let cli = Cli::new();
    let closed = cli.actuator("get 6041 --bus 127.0.0.1:1").assert().code(1);
    let error = String::from_utf8_lossy(&closed.get_output().stderr).into_owned();
    assert!(
        error.contains("cannot open the bus `127.0.0.1:1`"),
        "{error}"
    );
}

#[test]
fn a_captured_excitation_is_read_with_its_columns() {
    let served = Served::new(&["--seed", "3"]);
    served.text("excite doublet --amplitude 4 --unit 0.1 --capture");
    let text = served.text("record --capture");
    let mut lines = text.lines();
    let header = lines.next().expect("a header");
    assert!(
        header.starts_with("time_s,angle_mdeg,rate_mdeg_s,"),
        "{header}"
    );
    assert!(header.ends_with("command_mdeg,supply_mv"));
    let commands: Vec<i64> = lines
        .map(|line| {
            let command = line.rsplit(',').nth(1);
            command.expect("a field").parse().expect("whole")
        })
        .collect();
    let base = commands[commands.len() - 1];
    let doublet: Vec<_> = commands
        .iter()
        .take(51)
        .map(|command| command - base)
        .collect();
    let expected: Vec<_> = [4_000; 25]
        .into_iter()
        .chain([-4_000; 25])
        .chain([0])
        .collect();
    assert_eq!(doublet, expected);
    // The capture ended with the excitation, two pulses of 100 ms, before the buffer was full.
    assert!(commands.len() < 250, "{}", commands.len());
    served.text("record --capture --out capture.csv");
    let cli = &served.cli;
    let fit = cli.text("identify capture.csv --model black-box-1 --starts 1");
    assert!(fit.contains("pole_rad_s"), "{fit}");
}

/// The commands with a capture in docs/identification.md, in their order. The inertia of the served
/// actuator is 0.0232 kg m^2.
#[test]
fn the_documented_recipe_of_a_motor_gives_its_inertia_within_three_standard_errors() {
    let served = Served::new(&[]);
    let page = include_str!("../../../docs/identification.md").replace("\\\n", "");
    let blocks = page.split("```sh\n").skip(1);
    let blocks = blocks.filter_map(|block| block.split("```").next());
    let recipe = blocks.filter(|block| block.contains("capture.csv"));
    let commands: Vec<&str> = recipe
        .flat_map(str::lines)
        .filter_map(|line| line.strip_prefix("actuator "))
        .collect();
    assert_eq!(commands.len(), 5, "{commands:?}");
    for command in commands {
        match command.starts_with("identify") {
            true => drop(served.cli.text(&format!("{command} --json fit.json"))),
            false => drop(served.text(command)),
        }
    }
    let fit = json(&served.cli.read("fit.json"));
    let parameters = fit["models"][0]["parameters"].as_array().expect("a list");
    let named = |name: &str| parameters.iter().find(|p| p["name"] == name).expect(name);
    let [inertia, error] = ["estimate", "standard_error_coloured"].map(|key| {
        let inertia = &named("motor_inertia_kg_m2")[key];
        inertia.as_f64().expect("a number")
    });
    assert!(error < 0.05 * inertia, "{inertia} +- {error}");
    assert!(
        (inertia - 0.0232).abs() < 3.0 * error,
        "{inertia} +- {error}"
    );
    // The mean of the recording.
    let supply_v = named("supply_v")["estimate"].as_f64().expect("a number");
    assert!((supply_v - 6.0).abs() < 0.3, "{supply_v}");
    // Without it no torque constant is right, and none is written.
    served
        .cli
        .text("simulate board --plant bench --every 80 --csv without.csv");
    let message = "without.csv: supply_v is not known, expected its column";
    served
        .cli
        .assert_error("identify without.csv --model motor-m1", 2, message);
}

#[test]
fn a_running_capture_is_an_error_of_the_state_and_a_refused_excitation_starts_no_capture() {
    let served = Served::new(&[]);
    served.text("set 2030:1=1");
    let error = served.error("record --capture", 3);
    assert!(error.contains("2030:1=0"), "{error}");
    served.text("set 2030:1=0");
    served.text("set 607D:1=-2000 607D:2=2000");
    let error = served.error("excite doublet --amplitude 4 --capture", 3);
    assert!(error.contains("leave the position limits 607Dh"), "{error}");
    let phase = served.text("get 2030:2");
    assert!(
        ["0\n", "3\n"].contains(&&*phase),
        "{phase} is neither idle nor at its end"
    );
}

#[test]
fn a_failed_move_disables_the_drive() {
    let served = Served::new(&[]);
    served.text("set 6081=1");
    let error = served.error("move 20 --within 0.2 --release", 3);
    assert!(error.contains("the angle to be reached"), "{error}");
    let status: u16 = served.text("get 6041").trim().parse().expect("a number");
    assert_ne!(
        status & 0x6F,
        0x27,
        "operation is not enabled: {status:04X}h"
    );
}

#[test]
fn a_recording_as_json_has_one_object_per_line_with_the_columns_of_the_file() {
    let served = Served::new(&[]);
    let lines = served.text("record --for 0.2 --json");
    let parse = |line: &str| -> serde_json::Value { serde_json::from_str(line).expect("JSON") };
    let samples: Vec<_> = lines.lines().map(parse).collect();
    assert!(samples.len() > 10, "{}", samples.len());
    assert!(samples.iter().all(|sample| sample["time_s"].is_number()));
    let answer = parse(&served.text("record --for 0.2 --json --out run.csv"));
    let csv = served.cli.read("run.csv");
    assert_eq!(
        answer["rows"].as_u64(),
        Some(csv.lines().count() as u64 - 1)
    );
    let names: Vec<_> = csv.lines().next().expect("a header").split(',').collect();
    let keys = samples[0].as_object().expect("an object");
    assert_eq!(keys.len(), names.len());
    assert!(names.iter().all(|name| keys.contains_key(*name)));
}

#[cfg(unix)]
#[test]
fn an_interrupt_ends_the_monitor_with_status_0() {
    let served = Served::new(&[]);
    let mut monitor = Command::new(assert_cmd::cargo::cargo_bin!("actuator"))
        .args(["monitor", "--json", "--bus", &served.bus])
        .stdout(Stdio::piped())
        .spawn()
        .expect("it starts");
    let mut line = String::new();
    let mut out = BufReader::new(monitor.stdout.as_mut().expect("piped"));
    out.read_line(&mut line).expect("a line");
    assert!(line.contains("time_s"), "{line}");
    let pid = monitor.id().to_string();
    let killed = Command::new("kill").args(["-INT", &pid]).status();
    assert!(killed.is_ok_and(|status| status.success()));
    assert_eq!(monitor.wait().expect("it ends").code(), Some(0));
}

#[cfg(unix)]
#[test]
fn an_interrupt_ends_the_server_with_status_0_and_without_messages() {
    let mut served = Served::new(&[]);
    let pid = served.process.id().to_string();
    let killed = Command::new("kill").args(["-INT", &pid]).status();
    assert!(killed.is_ok_and(|status| status.success()));
    assert_eq!(served.process.wait().expect("it ends").code(), Some(0));
    let mut rest = String::new();
    let out = served.process.stdout.as_mut().expect("piped");
    out.read_to_string(&mut rest).expect("UTF-8");
    assert_eq!(rest, "");
}
