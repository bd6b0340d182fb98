//! Headers, times and units of text files.

use super::*;

/// The recording of a text, which may be incomplete.
fn recording(import: &Import, text: impl AsRef<[u8]>) -> Recording {
    read_as(import, "run.csv", text)
        .expect("it is read")
        .recording
}

#[test]
fn the_header_is_the_last_line_of_text_or_comment_before_the_numbers() {
    for text in [
        "# time_s,command_deg,angle_deg\n0,1,2\n0.1,3,4\n",
        "# made by numpy\n# time_s command_deg angle_deg\n0 1 2\n0.1 3 4\n",
        "% time_s, command_deg, angle_deg\n0 1 2\n0.1 3 4\n",
        "sep=;\ntime_s;command_deg;angle_deg\n0;1;2\n0,1;3;4\n",
        "Device: bench 3\nDate;2026-01-15\n\ntime_s;command_deg;angle_deg\n0;1;2\n0,1;3;4\n",
        "time,command,angle\n[s],[deg],[deg]\n0,1,2\n0.1,3,4\n",
        "time_s,mode,command_deg,angle_deg\n0,auto,1,2\n0.1,auto,3,4\n",
        "time_s,command_deg,angle_deg\n0,1,2,\n0.1,3,4,\n",
        // A spreadsheet with a preamble and a footer, both as wide as the table.
        "Bench 7;;\nDate;01.05.2024;\n;;\nZeit;Soll;Ist\ns;\u{b0};\u{b0}\n0;1;2\n0,1;3;4\n;;\nend;;\n",
        "time,target,position\nSecond,deg,deg\n0,1,2\n0.1,3,4\n",
        // LabVIEW: two heads, and comments that most lines lack.
        "LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\t\nChannels\t2\nX0\t0\t0\n\
         Delta_X\t0.1\t0.1\n***End_of_Header***\t\t\nX_Value\tCommand\tPosition\tComment\n\
         0\t1\t2\n0.1\t3\t4\n",
        "LabVIEW Measurement\nSeparator\tTab\n***End_of_Header***\n\nChannels\t2\nDelta_X\t0.1\t0.1\n\
         ***End_of_Header***\nX_Value\tCommand\tPosition\n0\t1\t2\n0.1\t3\t4\n",
        "LabVIEW 2020 export\ntime_s\tcommand_deg\tangle_deg\n0\t1\t2\n0.1\t3\t4\n",
        "time_s,command_deg,angle_deg\n0,1,2\ntime_s,command_deg,angle_deg\n0.1,3,4\n",
        "time_s,command_deg,angle_deg\r\n0,1,2\r\n0.1,3,4\r\n0.2,5",
    ] {
        let read = recording(&Import::default(), text);
        assert_eq!(read.time_s, [0.0, 0.1], "{text}");
        assert_eq!(read.command_deg, [1.0, 3.0], "{text}");
        assert_eq!(read.angle_deg, [2.0, 4.0], "{text}");
    }
}

#[test]
fn text_in_utf_16_and_in_latin_1_is_read() {
    let text = "time_s,command (\u{b0}),angle (\u{b0})\n0,1,2\n0.1,3,4\n";
    let utf_16 = |bytes: fn(u16) -> [u8; 2]| -> Vec<u8> {
        let units = "\u{feff}".encode_utf16().chain(text.encode_utf16());
        units.flat_map(bytes).collect()
    };
    let latin_1: Vec<u8> = text
        .chars()
        .map(|c| u8::try_from(u32::from(c)).expect("Latin-1"))
        .collect();
    for bytes in [
        utf_16(u16::to_le_bytes),
        utf_16(u16::to_be_bytes),
        utf_16(u16::to_le_bytes)[2..].to_vec(),
        latin_1,
        text.into(),
    ] {
        let Imported { recording, notes } =
            read_as(&Import::default(), "run.csv", bytes).expect("text");
        assert_eq!(recording.angle_deg, [2.0, 4.0]);
        assert_eq!(notes, []);
    }
}

#[test]
fn samples_at_equal_intervals_need_no_time() {
    let import = Import {
        rate_hz: Some(250.0),
        ..Import::default()
    };
    let read = recording(&import, "command_deg,angle_deg\n1,2\n3,4\n5,6\n");
    assert_eq!(read.time_s, [0.0, 0.004, 0.008]);
}

#[test]
fn a_time_without_unit_is_judged_by_the_steps_of_its_samples() {
    for (step, expected, unit) in [
        (0.02, 0.02, None),
        (1.0, 1e-3, Some("ms")),
        (20.0, 0.02, Some("ms")),
        (4000.0, 4e-3, Some("us")),
        (5e6, 5e-3, Some("ns")),
    ] {
        let rows: String = (0..60)
            .map(|i| format!("{},{i},{i}\n", step * f64::from(i)))
            .collect();
        let text = format!("time,command_deg,angle_deg\n{rows}");
        let Imported { recording, notes } = read(&text).expect("a ramp");
        assert!((recording.time_s[1] - expected).abs() < 1e-12, "{step}");
        assert_eq!(notes.len(), usize::from(unit.is_some()), "{notes:?}");
        let said = notes.first().map_or("", |note| &note.text);
        assert!(
            unit.is_none_or(|unit| said.contains(&format!("it is in {unit};"))),
            "{said}"
        );
    }
    // A given unit is not judged.
    let rows: String = (0..60).map(|i| format!("{i},{i},{i}\n")).collect();
    let slow = read(&format!("time_s,command_deg,angle_deg\n{rows}")).expect("a ramp");
    assert_eq!((slow.recording.time_s[1], slow.notes.len()), (1.0, 0));
}

#[test]
fn dates_are_times() {
    let text =
        "time,command_deg,angle_deg\n2026-01-15T10:28:59.99Z,1,2\n2026-01-15T10:29:00.01Z,3,4\n";
    let read = recording(&Import::default(), text);
    // The resolution of seconds since 1970 in 64 bits is 0.24 us.
    assert!((read.time_s[1] - 0.02).abs() < 1e-6, "{:?}", read.time_s);
}

#[test]
fn samples_of_a_coarse_clock_are_spread_over_its_steps() {
    let row = |i: u32| format!("{},{i},{i}\n", f64::from(i / 5) * 0.02);
    let rows: String = (0..100).map(row).collect();
    let Imported { recording, notes } =
        read(&format!("t_s,command_deg,angle_deg\n{rows}")).expect("a ramp");
    for (i, time_s) in recording.time_s.iter().enumerate() {
        assert!((time_s - 0.004 * i as f64).abs() < 1e-12, "{i}: {time_s}");
    }
    assert!(
        notes[0]
            .text
            .contains("80 rows have the time of the row before"),
        "{notes:?}"
    );
}

#[test]
fn names_of_servo_buses_robots_and_controllers_are_known_with_their_units() {
    let rad = 1_f64.to_degrees();
    for (header, expected) in [
        ("time_s,input_pos,pos_estimate", 360.0),
        ("time_s,q_des,q", rad),
        ("time_s,joint_pos_target,joint_pos", rad),
        ("time_s,goal_position,present_position", 1.0),
        ("time_s,target,actual", 1.0),
        ("time_s,demand_rev,actual_rev", 360.0),
        ("time_s,control_position,position", 1.0),
        ("time_s,command_m,position_m", 1e3),
        ("__time,/arm/command,/arm/joint_states/position", 1.0),
        ("__time,/arm/command/position,/arm/state/position", 1.0),
        ("__time,/servo/command/data,/servo/state/position", 1.0),
        ("Zeit,Soll,Ist", 1.0),
    ] {
        let read = recording(
            &Import::default(),
            format!("{header}\n0,1,1\n0.1,1.5,1.5\n"),
        );
        assert_eq!(read.command_deg, [expected, 1.5 * expected], "{header}");
        assert_eq!(read.angle_deg, read.command_deg, "{header}");
    }
}

#[test]
fn whole_numbers_beyond_a_turn_in_degrees_are_counts_of_an_encoder() {
    let text = |last: &str| {
        format!("time_s,goal_position,present_position\n0,2048,2048\n0.1,2048,{last}\n")
    };
    let Imported { recording, notes } = read(&text("1024")).expect("counts");
    assert_eq!(
        (recording.command_deg[0], recording.angle_deg[1]),
        (180.0, 90.0)
    );
    assert!(
        notes[0].text.contains("counts of 4096 a turn are assumed"),
        "{notes:?}"
    );
    let fraction = read(&text("1990.5")).expect("no counts").recording;
    assert_eq!(fraction.angle_deg[1], 1990.5);
}

#[test]
fn a_joint_selects_its_columns_and_several_joints_are_ambiguous() {
    let text = "time_s,/cmd/arm,/state/arm/position,/cmd/forearm,/state/forearm/position\n\
                0,1,2,3,4\n0.1,5,6,7,8\n";
    let error = read(text).expect_err("two joints");
    assert!(error.contains("--joint"), "{error}");
    let import = Import {
        columns: Columns {
            selected: Vec::new(),
            joint: Some("arm".into()),
        },
        ..Import::default()
    };
    let read = recording(&import, text);
    assert_eq!((read.command_deg[1], read.angle_deg[1]), (5.0, 6.0));
}

#[test]
fn a_length_is_noted_and_a_duty_beyond_100_percent_is_left_out() {
    let text = "time_s,command_mm,position_mm,pwm\n0,1,1,200\n0.1,2,2,-255\n";
    let Imported { recording, notes } = read(text).expect("a linear actuator");
    assert_eq!(recording.duty_pct, None);
    let said: Vec<&str> = notes.iter().map(|note| &*note.text).collect();
    assert!(
        said.iter()
            .filter(|text| text.contains("is a length"))
            .count()
            == 2,
        "{said:?}"
    );
    assert!(
        said.iter().any(|text| text.contains("reaches 255 %")),
        "{said:?}"
    );
    let scaled = with_columns(&["duty=pwm:0.392156862745098"]);
    let read = read_as(&scaled, "run.csv", text).expect("a duty").recording;
    assert!((read.duty_pct.expect("a duty")[1] + 100.0).abs() < 1e-9);
}
