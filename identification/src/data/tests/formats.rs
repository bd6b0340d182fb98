//! Envelopes and formats other than text.

use std::io::Write;

use flate2::{Compression, write::GzEncoder};

use super::*;

const TEXT: &str = "time_s,command_deg,angle_deg\n0,1,2\n0.1,3,4\n";

fn gzipped(bytes: &[u8]) -> Vec<u8> {
    let mut file = GzEncoder::new(Vec::new(), Compression::fast());
    file.write_all(bytes).expect("memory");
    file.finish().expect("memory")
}

fn zipped(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for (name, bytes) in files {
        let options = zip::write::SimpleFileOptions::default();
        archive.start_file(*name, options).expect("memory");
        archive.write_all(bytes).expect("memory");
    }
    archive.finish().expect("memory").into_inner()
}

#[test]
fn envelopes_are_removed_whatever_the_name_is() {
    let gz = gzipped(TEXT.as_bytes());
    for bytes in [
        gz.clone(),
        zipped(&[("run/run.csv", TEXT.as_bytes()), ("__MACOSX/run.csv", b"x")]),
        zipped(&[("run.csv.gz", &gz)]),
    ] {
        let read = read_as(&Import::default(), "run.dat", bytes).expect("a file");
        assert_eq!(read.recording.angle_deg, [2.0, 4.0]);
    }
    let two = zipped(&[("a.csv", b"1"), ("b.csv", b"2")]);
    let error = read_as(&Import::default(), "run.zip", two).expect_err("two files");
    assert_eq!(
        error,
        "run.zip:1: a zip archive with 2 files, expected one: a.csv, b.csv"
    );
}

#[test]
fn a_file_that_is_not_read_is_named() {
    for (bytes, expected) in [
        (&b"SQLite format 3\0..."[..], "a SQLite database"),
        (b"\xd0\xcf\x11\xe0....", "a workbook of Excel before 2007"),
        (b"\x28\xb5\x2f\xfd..", "a zstd file, expected it unpacked"),
        (b"\x1f\x8bxx", "it cannot be unpacked"),
        (b"PK\x03\x04xx", "a damaged zip archive"),
        (
            b"\x01\x00\x02\x00\n",
            "a line with a byte of zero, expected text",
        ),
    ] {
        let error = read_as(&Import::default(), "run.csv", bytes).expect_err("not readable");
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn json_of_records_lines_arrays_and_data_frames_is_read() {
    for text in [
        r#"[{"time_s": 0, "command_deg": 1, "angle_deg": 2}, {"time_s": 0.1, "command_deg": 3, "angle_deg": 4}]"#,
        "{\"time_s\": 0, \"command_deg\": 1, \"angle_deg\": 2}\n{\"time_s\": 0.1, \"command_deg\": 3, \"angle_deg\": 4}\n",
        r#"{"rate": 10, "time_s": [0, 0.1], "command_deg": [1, 3], "angle_deg": [2, 4]}"#,
        r#"{"run": {"time_s": [0, 0.1], "command_deg": [1, 3], "angle_deg": [2, 4]}}"#,
        r#"{"time_s": {"9": 0, "10": 0.1}, "command_deg": {"9": 1, "10": 3}, "angle_deg": {"9": 2, "10": 4}}"#,
        r#"{"columns": ["time_s", "command_deg", "angle_deg"], "index": [0, 1], "data": [[0, 1, 2], [0.1, 3, 4]]}"#,
        r#"{"meta": "x", "samples": [{"time_s": 0, "command_deg": 1, "angle_deg": 2}, {"time_s": "0.1", "command_deg": 3, "angle_deg": 4}]}"#,
    ] {
        let read = read_as(&Import::default(), "run.json", text)
            .expect(text)
            .recording;
        assert_eq!(read.time_s, [0.0, 0.1], "{text}");
        assert_eq!(
            (read.command_deg[1], read.angle_deg[1]),
            (3.0, 4.0),
            "{text}"
        );
    }
    let import = with_columns(&["time=1", "command=2", "angle=3"]);
    let rows = read_as(&import, "run.json", "[[0, 1, 2], [0.1, 3, 4]]").expect("rows");
    assert_eq!(rows.recording.angle_deg, [2.0, 4.0]);
}

#[test]
fn joint_states_of_ros_have_radians_and_their_joints() {
    let message = |seconds: u32, angle: f64| {
        format!(
            r#"{{"header": {{"stamp": {{"sec": {seconds}, "nanosec": 500000000}}, "frame_id": ""}}, "name": ["wrist", "elbow"], "position": [9, {angle}], "velocity": [0, 0], "effort": [0, 0]}}"#
        )
    };
    let text = format!("{}\n{}\n", message(0, 0.0), message(1, 0.5));
    let import = Import {
        columns: Columns {
            selected: Vec::new(),
            joint: Some("elbow".into()),
        },
        may_lack_command: true,
        ..Import::default()
    };
    let read = read_as(&import, "run.json", text)
        .expect("messages")
        .recording;
    assert_eq!(read.time_s, [0.5, 1.5]);
    assert_eq!(read.angle_deg, [0.0, 0.5_f64.to_degrees()]);
}

/// A message of a dataflash log.
fn message(kind: u8, body: &[&[u8]]) -> Vec<u8> {
    let mut bytes = vec![0xa3, 0x95, kind];
    bytes.extend(body.concat());
    bytes
}

/// The message that describes another one.
fn format_of(kind: u8, length: u8, name: &str, types: &str, fields: &str) -> Vec<u8> {
    let padded = |text: &str, length| {
        let mut bytes = text.as_bytes().to_vec();
        bytes.resize(length, 0);
        bytes
    };
    let texts = [padded(name, 4), padded(types, 16), padded(fields, 64)].concat();
    message(128, &[&[kind, length], &texts])
}

#[test]
fn the_servo_messages_of_an_autopilot_are_rows_at_their_own_times() {
    let mut log = [
        format_of(128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns"),
        format_of(1, 15, "RCOU", "QHH", "TimeUS,C1,C2"),
        format_of(2, 25, "CSRV", "QBfffB", "TimeUS,Id,Pos,Force,Speed,Pow"),
    ]
    .concat();
    for i in 0..10_u64 {
        let (pulse, angle) = (
            (1500 + 10 * i as u16).to_le_bytes(),
            (0.1 * i as f32).to_le_bytes(),
        );
        log.extend(message(1, &[&(20_000 * i).to_le_bytes(), &pulse, &[0; 2]]));
        let time = (20_000 * i + 5000).to_le_bytes();
        log.extend(message(2, &[&time, &[3], &angle, &[0; 9]]));
        // A damaged byte.
        log.push(7);
    }
    let import = with_columns(&["command=RCOU.C1:0.09", "angle=CSRV3.Pos"]);
    let read = read_as(&import, "00000012.BIN", log)
        .expect("a log")
        .recording;
    assert_eq!(read.len(), 20);
    assert_eq!(read.command_deg[18], 1590.0 * 0.09);
    assert!((read.angle_deg[19] - 0.9_f64.to_degrees()).abs() < 1e-5);
    assert!(read.angle_deg[18].is_nan() && read.command_deg[19].is_nan());
    assert!((read.time_s[19] - 0.185).abs() < 1e-12);
}

/// As the other files of other libraries, by `files.py`.
const MATRIX: &[u8] = include_bytes!("matrix.mat");

#[test]
fn the_columns_of_a_matrix_are_columns() {
    for third in ["data(:,3)", "data[:,3]", "3"] {
        let angle = format!("angle={third}");
        let import = with_columns(&["time=data(:,1)", "command=data(:,2):rad", &angle]);
        let read = read_as(&import, "run.mat", MATRIX)
            .expect("a matrix")
            .recording;
        assert_eq!(read.time_s, [0.0, 0.1, 0.2, 0.3]);
        assert!(
            (read.angle_deg[3] - 8_f64.to_degrees()).abs() < 1e-9,
            "{third}"
        );
    }
    let error = read_as(&Import::default(), "run.mat", MATRIX).expect_err("no names");
    assert!(
        error.contains("`data(:,1)`, `data(:,2)`, `data(:,3)`"),
        "{error}"
    );
}

#[test]
fn vectors_of_other_lengths_are_named_where_a_column_is_missing() {
    let text = r#"{"time_s": [0, 1, 2], "command_deg": [1, 2, 3], "angle_deg": [1, 2]}"#;
    let error = read_as(&Import::default(), "run.json", text).expect_err("two lengths");
    assert!(
        error.contains("left out are `angle_deg` with 2 samples, where others have 3"),
        "{error}"
    );
}

/// A table of two rows by pandas and h5py.
#[cfg(all(feature = "parquet", feature = "xlsx", feature = "hdf5"))]
#[test]
fn workbooks_parquet_and_hdf5_are_read() {
    for bytes in [
        &include_bytes!("table.xlsx")[..],
        include_bytes!("table.parquet"),
        include_bytes!("table.h5"),
    ] {
        let read = read_as(&Import::default(), "run.dat", bytes)
            .expect("a table")
            .recording;
        assert_eq!(read.time_s, [0.0, 0.1]);
        assert_eq!((read.command_deg[1], read.angle_deg[1]), (3.0, 4.0));
        // A cut file is refused.
        let cut = &bytes[..bytes.len() / 2];
        read_as(&Import::default(), "run.dat", cut).expect_err("cut off");
    }
}

#[cfg(not(any(
    feature = "parquet",
    feature = "xlsx",
    feature = "hdf5",
    feature = "mcap"
)))]
#[test]
fn formats_that_the_program_was_built_without_are_named() {
    for (bytes, expected) in [
        (
            &include_bytes!("table.xlsx")[..],
            "a workbook of Excel, which this program",
        ),
        (
            include_bytes!("table.parquet"),
            "a Parquet file, which this program",
        ),
        (
            include_bytes!("table.h5"),
            "an HDF5 file, as MAT of version 7.3 is, which this",
        ),
        (include_bytes!("bag.mcap"), "an MCAP file, which this"),
    ] {
        let error = read_as(&Import::default(), "run.dat", bytes).expect_err("not built");
        assert!(error.contains(expected), "{error}");
    }
}

/// Of ROS 2, by the writer of MCAP's authors.
#[cfg(feature = "mcap")]
#[test]
fn messages_of_a_bag_are_rows_at_their_own_instants() {
    let import = Import {
        columns: Columns {
            selected: vec![
                "command=/arm/commands.data[0]:deg"
                    .parse()
                    .expect("a column"),
            ],
            joint: Some("elbow".into()),
        },
        ..Import::default()
    };
    let bag = include_bytes!("bag.mcap");
    let read = read_as(&import, "bag", bag).expect("a bag").recording;
    // Not those of the log, which is late by up to 1.5 ms.
    assert_eq!(read.time_s, [0.0, 0.01, 0.02, 0.03]);
    assert_eq!(read.command_deg[0], 0.0);
    assert_eq!(read.command_deg[2], 2.0);
    let angle_deg = (3.0_f64 / 8.0).to_degrees();
    assert!((read.angle_deg[3] - angle_deg).abs() < 1e-12);
    let error = read_as(&Import::default(), "bag", bag).expect_err("two joints");
    assert!(error.contains("--joint JOINT"), "{error}");
    // What follows damage is left out, or nothing is left.
    for length in 0..bag.len() {
        let _ = read_as(&import, "bag", &bag[..length]);
    }
}

#[test]
fn columns_that_end_a_little_earlier_lack_their_last_samples_and_shorter_ones_are_left_out() {
    let column = |count: usize| {
        (0..count)
            .map(|i| i.to_string())
            .collect::<Vec<_>>()
            .join(",")
    };
    let text = format!(
        r#"{{"time_s": [{}], "command_deg": [{}], "angle_deg": [{}], "duty_pct": [{}]}}"#,
        column(400),
        column(399),
        column(397),
        column(100)
    );
    let read = read_as(&Import::default(), "run.json", text).expect("three columns");
    // The last time has neither command nor angle.
    assert_eq!(read.recording.angle_deg.len(), 399);
    assert!(read.recording.angle_deg[397].is_nan());
    let texts: Vec<&str> = read.notes.iter().map(|note| &*note.text).collect();
    assert!(texts.contains(&"column `angle_deg` ends 3 samples before the others"));
    assert!(texts.contains(&"column `duty_pct` with 100 samples is left out: others have 400"));
}

/// A table of groups of columns, each with its value at both samples.
fn grouped(groups: &[(&str, &[(&str, f64)])]) -> Table {
    let column = |(name, value): &(&str, f64)| ((*name).to_owned(), vec![*value; 2]);
    let group = |(name, columns): &(&str, &[_])| {
        let columns = columns.iter().map(column).collect();
        ((*name).to_owned(), columns)
    };
    let groups = groups.iter().map(group).collect();
    Table::default().with(Ok(groups)).expect("a table")
}

#[test]
fn a_quantity_is_looked_for_in_the_group_with_command_and_angle_first() {
    let error: (&str, &[_]) = ("error", &[("angle", 9.0), ("x", 9.0)]);
    let run: (&str, &[_]) = ("run", &[("command", 1.0), ("angle", 2.0)]);
    let table = grouped(&[error, run, ("", &[("t", 0.0)])]);
    assert_eq!(
        table.names,
        ["run.command", "run.angle", "error.angle", "error.x", "t"]
    );
    let import = Import {
        rate_hz: Some(1.0),
        ..Import::default()
    };
    let recording = |import: &Import, table: &Table| import.recording(table).map(|it| it.recording);
    let read = recording(&import, &table).expect("a recording");
    assert_eq!((read.command_deg[0], read.angle_deg[0]), (1.0, 2.0));
    let import = with_columns(&["command=x", "angle=run/command"]);
    let import = Import {
        rate_hz: Some(1.0),
        ..import
    };
    let read = recording(&import, &table).expect("a recording");
    assert_eq!((read.command_deg[0], read.angle_deg[0]), (9.0, 1.0));
}

#[test]
fn a_longer_group_without_command_and_angle_is_left_out() {
    let run = ["command", "angle"].map(|name| (name.to_owned(), vec![1.0, 2.0]));
    let events = vec![("code".to_owned(), vec![0.0; 9])];
    let groups = vec![
        ("events".to_owned(), events),
        ("run".to_owned(), run.to_vec()),
    ];
    let table = Table::default().with(Ok(groups)).expect("a table");
    assert_eq!((table.names.len(), table.len()), (2, 2));
    assert_eq!(table.left_out, ["`events.code` with 9 samples"]);
}

#[test]
fn of_two_recordings_in_a_file_one_is_chosen_by_its_name() {
    let left: (&str, &[_]) = ("left", &[("command", 1.0), ("angle", 2.0)]);
    let right: (&str, &[_]) = ("right", &[("command", 3.0), ("angle", 4.0)]);
    let gains: (&str, &[_]) = ("pid", &[("kp", 1.0), ("ki", 2.0)]);
    let table = grouped(&[gains, left, right]);
    let of_joint = |joint: Option<&str>| {
        let import = Import {
            columns: Columns {
                selected: Vec::new(),
                joint: joint.map(String::from),
            },
            rate_hz: Some(1.0),
            ..Import::default()
        };
        import.recording(&table).map(|it| it.recording.angle_deg[0])
    };
    let error = of_joint(None).expect_err("two recordings").to_string();
    let expected = "`left` and `right` both have command and angle, expected one recording";
    assert!(error.contains(expected), "{error}");
    assert_eq!(of_joint(Some("left")).ok(), Some(2.0));
    assert_eq!(of_joint(Some("right")).ok(), Some(4.0));
    assert_eq!(grouped(&[left]).names, ["command", "angle"]);
    let gains: &[(&str, &[_])] = &[left, gains, ("pid2", &[("kp", 1.0), ("ki", 2.0)])];
    assert_eq!(grouped(gains).rivals, None);
}

#[test]
fn of_lists_of_json_the_one_with_command_and_angle_is_the_recording() {
    let sample = r#"[{"t": 0, "command": 1, "angle": 2}]"#;
    let json = format!(r#"{{"events": [{{"code": 7}}], "run": {sample}}}"#);
    let read = read_as(&Import::default(), "run.json", json).expect("a recording");
    assert_eq!(read.recording.angle_deg, [2.0]);
    let json = format!(r#"{{"a": {sample}, "b": {sample}}}"#);
    let error = read_as(&Import::default(), "run.json", json).expect_err("two recordings");
    assert!(
        error.contains("`a` and `b` are lists of samples"),
        "{error}"
    );
}

#[test]
#[cfg(feature = "xlsx")]
fn a_workbook_with_two_recordings_is_refused() {
    const MAIN: &str = "http://schemas.openxmlformats.org/spreadsheetml/2006/main";
    const PACKAGE: &str = "http://schemas.openxmlformats.org/package/2006";
    const OF: &str = "http://schemas.openxmlformats.org/officeDocument/2006/relationships";
    let book = format!(
        r#"<workbook xmlns="{MAIN}" xmlns:r="{OF}"><sheets><sheet name="a" sheetId="1" r:id="a"/><sheet name="b" sheetId="2" r:id="b"/></sheets></workbook>"#
    );
    let link = |id: &str, kind: &str, target: &str| {
        format!(r#"<Relationship Id="{id}" Type="{OF}/{kind}" Target="{target}"/>"#)
    };
    let linked = |links: &[String]| {
        let links = links.concat();
        format!(r#"<Relationships xmlns="{PACKAGE}/relationships">{links}</Relationships>"#)
    };
    let root = linked(&[link("r1", "officeDocument", "xl/workbook.xml")]);
    let links =
        linked(&["a", "b"].map(|name| link(name, "worksheet", &format!("worksheets/{name}.xml"))));
    let row = r#"<row r="2"><c r="A2"><v>1</v></c></row>"#;
    let sheet = |header: &str| {
        let cells =
            format!(r#"<c r="A1" t="str"><v>{header}</v></c><c r="B1" t="str"><v>x</v></c>"#);
        format!(
            r#"<worksheet xmlns="{MAIN}"><sheetData><row r="1">{cells}</row>{row}</sheetData></worksheet>"#
        )
    };
    let error = |second: &str| {
        let workbook = zipped(&[
            ("_rels/.rels", root.as_bytes()),
            ("xl/workbook.xml", book.as_bytes()),
            ("xl/_rels/workbook.xml.rels", links.as_bytes()),
            ("xl/worksheets/a.xml", sheet("time_s").as_bytes()),
            ("xl/worksheets/b.xml", sheet(second).as_bytes()),
        ]);
        read_as(&Import::default(), "run.xlsx", workbook).expect_err("no recording")
    };
    let two = error("time_s");
    assert!(
        two.contains("have the same header, expected one recording"),
        "{two}"
    );
    let one = error("remarks");
    assert!(one.contains("no column is known"), "{one}");
}

#[test]
#[cfg(feature = "parquet")]
fn each_episode_of_a_lerobot_data_set_is_a_recording_of_the_joint() {
    for (names, version) in [
        (r#"["wrist.pos", "elbow.pos"]"#, "v3.0"),
        (r#"{"motors": ["wrist", "elbow"]}"#, "v2.1"),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        let data = folder.path().join("data/chunk-000");
        fs::create_dir_all(&data).expect("a folder");
        fs::create_dir_all(folder.path().join("meta")).expect("a folder");
        fs::write(
            data.join("file-000.parquet"),
            include_bytes!("episodes.parquet"),
        )
        .expect("data");
        let feature = format!(r#"{{"names": {names}}}"#);
        let info = format!(
            r#"{{"codebase_version": "{version}", "fps": 10, "features": {{"action": {feature}, "observation.state": {feature}}}}}"#
        );
        fs::write(folder.path().join("meta/info.json"), info).expect("the description");
        let of_joint = |joint: Option<&str>| Import {
            columns: Columns {
                selected: Vec::new(),
                joint: joint.map(String::from),
            },
            ..Import::default()
        };
        let read = |joint| of_joint(joint).read_all(folder.path(), &mut |_, _| {});
        let episodes = read(Some("elbow")).expect("two episodes");
        let recordings: Vec<_> = episodes.iter().map(|e| &e.recording).collect();
        assert_eq!(recordings[0].command_deg, [5.0, 6.0]);
        assert_eq!(recordings[1].angle_deg, [7.0, 8.0]);
        assert_eq!(recordings[1].name, "episode 1");
        assert!(
            episodes[0].notes[0].text.contains("10 Hz"),
            "{:?}",
            episodes[0].notes
        );
        let error = read(None).expect_err("no joint").to_string();
        assert!(
            error.contains("expected --joint with one of wrist, elbow"),
            "{error}"
        );
        let error = read(Some("nose")).expect_err("no joint").to_string();
        let expected = "no joint `nose`, expected --joint with one of wrist, elbow";
        assert!(error.contains(expected), "{error}");
        assert_eq!(read(Some("elbow.pos")).expect("two episodes").len(), 2);
    }
}
