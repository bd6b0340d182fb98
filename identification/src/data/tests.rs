//! Import of typical files, which the tests write.

use std::{fs, path::PathBuf};

use super::*;

mod ambiguous;
mod formats;
mod headers;

struct File {
    path: PathBuf,
    _folder: tempfile::TempDir,
}

fn file(name: &str, text: impl AsRef<[u8]>) -> File {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(name);
    fs::write(&path, text).expect("a file");
    File {
        path,
        _folder: folder,
    }
}

fn read_as(import: &Import, name: &str, text: impl AsRef<[u8]>) -> Result<Imported, String> {
    let file = file(name, text);
    let read = import.read(&file.path, &mut |_, _| {});
    read.map_err(|error| {
        let folder = file.path.parent().expect("a folder");
        let text = error.to_string();
        text.replace(&format!("{}/", folder.display()), "")
    })
}

fn read(text: &str) -> Result<Imported, String> {
    read_as(&Import::default(), "run.csv", text)
}

fn with_columns(columns: &[&str]) -> Import {
    let choices = columns.iter().map(|text| text.parse().expect("a choice"));
    Import {
        columns: Columns {
            selected: choices.collect(),
            joint: None,
        },
        ..Import::default()
    }
}

#[test]
fn a_trace_of_the_simulator_needs_no_options() {
    let header =
        "t,command,command_delayed,angle_deg,rate_deg_s,duty_pct,angle_meas_deg,current_a\n";
    let imported = read(&format!(
        "{header}0,90,0,1,2,3,4,0.5\n0.004,90,0,1,2,3,5,0.5\n"
    ));
    let Imported { recording, notes } = imported.expect("a trace");
    assert_eq!(recording.time_s, [0.0, 0.004]);
    // The measured columns take precedence over the true ones.
    assert_eq!(recording.angle_deg, [4.0, 5.0]);
    assert_eq!(recording.command_deg, [90.0, 90.0]);
    assert_eq!(recording.current_ma.as_deref(), Some(&[500.0, 500.0][..]));
    assert_eq!(notes, []);
}

#[test]
fn columns_are_named_with_their_units_on_the_command_line() {
    let import = with_columns(&["time=clock:ms", "angle=pos:rad", "command=3:0.1"]);
    let text = "pos;clock;cmd counts\n1,5;0;10\n0,5;20;20\n";
    let recording = read_as(&import, "run.csv", text)
        .expect("it is mapped")
        .recording;
    assert_eq!(recording.time_s, [0.0, 0.02]);
    assert!((recording.angle_deg[0] - 1.5_f64.to_degrees()).abs() < 1e-9);
    assert_eq!(recording.command_deg, [1.0, 2.0]);
}

#[test]
fn units_are_read_from_the_header_or_the_line_below_or_assumed() {
    for text in [
        "time (ms),setpoint [rad],pos_rad\n0,0,0\n20,1,1\n",
        "time,setpoint,pos\nms,rad,rad\n0,0,0\n20,1,1\n",
        "time_ms\tcommand\tangle_rad\n0\t0\t0\n20\t1\t1\n",
        "t_ms  ref_rad  theta_rad\n 0  0 0\n20 1   1\n",
    ] {
        let Imported { recording, notes } = read(text).expect(text);
        assert_eq!(recording.time_s, [0.0, 0.02], "{text}");
        for column in [&recording.command_deg, &recording.angle_deg] {
            assert!((column[1] - 57.295_779_513).abs() < 1e-8, "{text}");
        }
        assert_eq!(notes, [], "{text}");
    }
    let unknown = read("t,command,position\n0,0,0\n1,1,1\n").expect("deg");
    assert_eq!(unknown.recording.angle_deg, [0.0, 1.0]);
    assert!(unknown.notes[0].text.contains("deg is assumed"));
}

#[test]
fn a_file_without_header_names_its_columns_by_number() {
    let import = with_columns(&["time=1", "command=2:deg", "angle=3:deg"]);
    let recording = read_as(&import, "run.txt", "0,1,2\n1,3,4\n")
        .expect("numbers")
        .recording;
    assert_eq!(recording.angle_deg, [2.0, 4.0]);
    let error = read("0,1,2\n1,3,4\n").expect_err("ambiguous");
    assert_eq!(
        error,
        "run.csv:1: no column is known to be the time, nor the command, nor the angle: the columns \
         are `1`, `2`, `3`, expected --column time=COLUMN:UNIT --column command=COLUMN:UNIT \
         --column angle=COLUMN:UNIT; --rate HZ in place of a time for samples at equal intervals"
    );
}

#[test]
fn every_error_names_file_and_line() {
    let header = "t,command_deg,angle_deg\n";
    for (text, expected) in [
        (
            "",
            "run.csv:1: the file is empty, expected a header and samples",
        ),
        (
            "# nothing\n\n",
            "run.csv:2: the file is empty, expected a header and samples",
        ),
        (
            "t,angle_deg\n0,0\n",
            "run.csv:1: no column is known to be the command",
        ),
        (
            "t,u,angle_deg,angle_rad\n0,0,0,0\n",
            "may both be the angle",
        ),
        (
            &format!("{header}0,0,0\n1,0\n2,0,0\n"),
            "run.csv:3: the fields are 2, expected 3 as in the header",
        ),
        (
            &format!("{header}0,0,0\n1,0,abc\n"),
            "run.csv:3: column 3 (`angle_deg`) is `abc`, expected a finite number",
        ),
        (
            &format!("{header}0,0,0\n1,inf,0\n"),
            "run.csv:3: column 2 (`command_deg`) is `inf`, expected a finite number",
        ),
        (
            &format!("{header}0,0,0\n# why\n2,0,0\n1,0,0\n"),
            "run.csv:5: the time is 1 s after 2 s, expected times that do not decrease",
        ),
    ] {
        let error = read(text).expect_err(text);
        assert!(error.contains(expected), "{text:?}: {error}");
    }
    let import = with_columns(&["angle=pos"]);
    let error = read_as(&import, "run.csv", "t,u\n0,0\n").expect_err("no such column");
    assert_eq!(
        error,
        "run.csv:1: no column `pos`: the columns are `t`, `u`"
    );
}

#[test]
fn missing_numbers_repeated_times_and_gaps_are_noted_and_corrected() {
    let mut text = String::from("t,command_deg,angle_deg\n");
    for i in 0..20 {
        text += &format!("{},1,{i}\n", f64::from(i) / 10.0);
    }
    text += "1.9,1,77\nNaN,1,78\n10,,79\n10.1,1,\n";
    let Imported { recording, notes } = read(&text).expect("it can be used");
    assert_eq!(recording.len(), 22);
    assert_eq!(recording.angle_deg[19], 77.0);
    assert!(recording.command_deg[20].is_nan() && recording.angle_deg[21].is_nan());
    let found: Vec<(u64, &str)> = notes
        .iter()
        .map(|note| (note.line, note.text.get(..16).unwrap_or(&note.text)))
        .collect();
    assert_eq!(
        found,
        [
            (22, "1 row has the ti"),
            (23, "1 row has no tim"),
            (24, "1 gap without sa"),
            (24, "1 sample has no "),
            (25, "1 sample has no "),
        ]
    );
}

#[test]
fn a_time_since_1970_keeps_its_resolution() {
    let text = "time_us,command_deg,angle_deg\n1700000000000001,0,0\n1700000000004001,0,1\n";
    let recording = read(text).expect("a date").recording;
    assert_eq!(recording.time_s, [0.0, 0.004]);
}

#[test]
fn a_wrapped_angle_is_unwrapped() {
    let text = "t,command_deg,angle_deg\n0,0,350\n1,0,358\n2,0,6\n3,0,14\n4,0,359\n";
    let Imported { recording, notes } = read(text).expect("angles");
    assert_eq!(recording.angle_deg, [350.0, 358.0, 366.0, 374.0, 359.0]);
    assert!(notes[0].text.contains("2 times"), "{}", notes[0]);
}

#[test]
fn a_command_within_the_same_turn_is_unwrapped_as_well() {
    let Imported { recording, notes } =
        read("t_s,command_deg,angle_deg\n0,350,340\n1,5,350\n2,20,5\n3,10,20\n")
            .expect("it can be used");
    assert_eq!(recording.command_deg, [350.0, 365.0, 380.0, 370.0]);
    assert_eq!(recording.angle_deg, [340.0, 350.0, 365.0, 380.0]);
    assert!(
        notes
            .iter()
            .any(|note| note.text.starts_with("the command jumps by a turn"))
    );
}

#[test]
fn a_step_of_nearly_a_turn_is_no_wrap_of_the_command() {
    let mut text = String::from("t_s,command_deg,angle_deg\n");
    // At rest near zero, the angle wraps by its noise.
    for i in 0..60 {
        let (command, angle) = match i {
            0..20 => (0.0, if i % 2 == 0 { 0.02 } else { 359.98 }),
            _ => (350.0, f64::min(50.0 * f64::from(i - 19), 350.0)),
        };
        text += &format!("{i},{command},{angle}\n");
    }
    let Imported { recording, notes } = read(&text).expect("it can be used");
    assert!(
        notes[0].text.starts_with("the angle jumps by a turn"),
        "{notes:?}"
    );
    assert_eq!(recording.command_deg[59] - recording.command_deg[0], 350.0);
    assert_eq!(recording.angle_deg[59], recording.command_deg[59]);
}

#[test]
fn a_command_is_on_the_turn_of_the_angle() {
    let Imported { recording, notes } =
        read("t_s,command_deg,angle_deg\n0,1,359\n1,2,359.5\n2,3,0.5\n3,4,2\n")
            .expect("it can be used");
    assert_eq!(recording.command_deg, [361.0, 362.0, 363.0, 364.0]);
    assert!(notes[1].text.contains("moved by a turn"), "{notes:?}");
    assert_eq!(recording.angle_deg, [359.0, 359.5, 360.5, 362.0]);
}

#[test]
fn rows_without_header_are_no_repeated_header() {
    let import = Import {
        rate_hz: Some(50.0),
        ..with_columns(&["command=1:deg", "angle=2:deg"])
    };
    let read = read_as(&import, "run.csv", "ready\n0,1\n1,2\n1,2\n2,3\n").expect("samples");
    assert_eq!(read.recording.angle_deg, [1.0, 2.0, 2.0, 3.0]);
}

#[test]
fn messages_a_moment_apart_are_no_gaps() {
    let row = |i: u32| {
        let time_s = 0.004 * f64::from(i);
        format!("{time_s},{i},\n{},,{i}\n", time_s + 2e-4)
    };
    let rows: String = (0..50).filter(|i| !(20..30).contains(i)).map(row).collect();
    let Imported { notes, .. } =
        read(&format!("t_s,command_deg,angle_deg\n{rows}")).expect("a ramp");
    let gaps: Vec<&str> = notes
        .iter()
        .map(|note| &*note.text)
        .filter(|text| text.contains("without samples"))
        .collect();
    assert_eq!(gaps.len(), 1, "{gaps:?}");
    assert!(gaps[0].starts_with("1 gap without samples"), "{gaps:?}");
}

#[test]
fn a_motor_of_many_turns_is_not_unwrapped() {
    let row = |i: i32| format!("{},0,{}\n", f64::from(i) * 0.02, 320 * i.min(20));
    let rows: String = (0..60).map(row).collect();
    let angles = read(&format!("t,command_deg,angle_deg\n{rows}")).expect("angles");
    assert_eq!(angles.recording.angle_deg.last(), Some(&6400.0));
}

#[test]
fn a_fast_motion_within_one_turn_is_not_unwrapped() {
    let text = "t,command_deg,angle_deg\n0,0,0\n1,0,5\n2,0,10\n3,0,300\n4,0,305\n5,0,305\n";
    let recording = read(text).expect("angles").recording;
    assert_eq!(recording.angle_deg, [0.0, 5.0, 10.0, 300.0, 305.0, 305.0]);
}

/// A sine of 10 deg, clipped at 7 deg.
fn cut_sine() -> String {
    let row = |i: i32| {
        let (t, angle) = (f64::from(i) * 0.01, 10.0 * (0.05 * f64::from(i)).sin());
        format!("{t},{angle},{}\n", angle.min(7.0))
    };
    let rows: String = (0..300).map(row).collect();
    format!("t,command_deg,angle_deg\n{rows}")
}

#[test]
fn clipped_samples_are_not_compared_unless_requested() {
    let cut = read(&cut_sine()).expect("a sine");
    let missing = cut
        .recording
        .angle_deg
        .iter()
        .filter(|a| a.is_nan())
        .count();
    // Three crests: 3 (pi - 2 asin 0.7)/0.05 = 95.4 samples.
    assert!((94..=97).contains(&missing), "{missing}");
    assert_eq!(cut.notes.len(), 3);
    let keep = Import {
        keep_clipped: true,
        ..Import::default()
    };
    let kept = read_as(&keep, "run.csv", cut_sine()).expect("a sine");
    assert!(kept.recording.angle_deg.iter().all(|a| a.is_finite()));
    assert_eq!(kept.notes.len(), 3);
}

#[test]
fn an_actuator_that_settles_on_an_encoder_is_not_clipped() {
    let lag = |i: i32| 90.0 * (1.0 - (-0.03 * f64::from(i)).exp());
    let row = |i: i32| {
        let counts = (lag(i) / 0.087_890_625).floor();
        format!("{},90,{}\n", f64::from(i) * 0.004, counts * 0.087_890_625)
    };
    let rows: String = (0..1000).map(row).collect();
    let imported = read(&format!("t,command_deg,angle_deg\n{rows}")).expect("a step");
    assert_eq!(imported.notes, []);
}

#[test]
fn a_fast_actuator_at_its_command_or_short_of_it_is_not_clipped() {
    for gain in [1.0, 0.3] {
        // It responds within one sample, two samples after the command.
        let row = |i: usize| {
            let command = |i: usize| if (20..60).contains(&i) { 90.0 } else { 0.0 };
            let angle = gain * command(i.saturating_sub(2));
            format!("{},{},{angle}\n", i as f64 * 0.02, command(i))
        };
        let rows: String = (0..100).map(row).collect();
        let imported = read(&format!("t,command_deg,angle_deg\n{rows}")).expect("a pulse");
        let clipped = imported.notes.len();
        // An abrupt stop cannot be distinguished from a clipped sensor.
        assert_eq!(clipped, usize::from(gain < 1.0), "{:?}", imported.notes);
    }
}

#[test]
fn an_actuator_held_by_friction_at_its_maximum_is_not_clipped() {
    // A third of the command, delayed and stuck for 20 samples after each maximum.
    let row = |i: i32| {
        let phase = |i: i32| 0.02 * f64::from(i);
        let late = phase(i) - 0.3;
        let since_crest = (late - std::f64::consts::FRAC_PI_2).rem_euclid(std::f64::consts::PI);
        let stuck = if since_crest < 0.4 {
            late - since_crest
        } else {
            late
        };
        let (command, angle) = (30.0 * phase(i).sin(), 10.0 * stuck.sin());
        format!(
            "{},{command},{}\n",
            f64::from(i) * 0.01,
            (angle * 1e6).round() / 1e6
        )
    };
    let rows: String = (0..1000).map(row).collect();
    let imported = read(&format!("t,command_deg,angle_deg\n{rows}")).expect("a sine");
    assert_eq!(imported.notes, []);
}

/// In the format of the recordings of BAM.
const BAM: &str = r#"{"mass": 0.49, "length": 0.1, "kp": 400, "vin": 7.4, "motor": "xl330",
"trajectory": "sin_sin", "entries": [
{"position": 0.1, "speed": 0.2, "load": 3, "input_volts": 7.3, "timestamp": 0.003, "goal_position": 0.0, "torque_enable": true},
{"position": null, "speed": 0.2, "load": 3, "input_volts": 7.3, "timestamp": 0.008, "goal_position": 0.5, "torque_enable": true}]}"#;

#[test]
fn json_of_a_pendulum_has_radians_and_known_values_of_the_run() {
    let Imported { recording, notes } =
        read_as(&Import::default(), "run.json", BAM).expect("a run");
    assert!((recording.angle_deg[0] - 0.1_f64.to_degrees()).abs() < 1e-12);
    assert!((recording.command_deg[1] - 0.5_f64.to_degrees()).abs() < 1e-12);
    assert_eq!(recording.constants["pendulum_mass_kg"], 0.49);
    assert_eq!(recording.constants["pendulum_length_m"], 0.1);
    assert_eq!(recording.supply_v.as_deref(), Some(&[7.3, 7.3][..]));
    assert_eq!((notes.len(), notes[0].line), (1, 4));
}

#[test]
fn broken_json_is_refused_with_its_line() {
    for (text, expected) in [
        ("{\n\"entries\": [\n{]}", "run.json:3: column 2"),
        ("{}", "run.json:1: no samples, expected a list of objects"),
        ("[\n3]", "run.json:2: sample 1"),
        ("[]", "run.json:1: no column is known to be the time"),
    ] {
        let error = read_as(&Import::default(), "run.json", text).expect_err(text);
        assert!(error.contains(expected), "{text:?}: {error}");
    }
}

#[test]
fn an_invalid_column_assignment_is_refused() {
    for (text, expected) in [
        ("angle", "expected QUANTITY=COLUMN"),
        (
            "angel=pos",
            "`angel` is not a quantity, expected one of time, command",
        ),
        (
            "angle=pos:volt",
            "`volt` is not a unit of angle, expected deg, mdeg, rad",
        ),
    ] {
        let error = text.parse::<ColumnSelection>().expect_err(text);
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn only_samples_in_the_window_are_imported() {
    let import = Import {
        window_s: Some((0.5, 1.5)),
        ..Import::default()
    };
    let text = "t,command_deg,angle_deg\n0,0,0\n1,0,1\n2,0,2\n";
    let recording = read_as(&import, "run.csv", text).expect("a part").recording;
    assert_eq!(recording.time_s, [1.0]);
}
