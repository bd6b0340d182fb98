//! Commands from CSV files.

use std::{fmt::Write as _, time::Duration};

use super::Cli;

#[test]
fn before_its_first_row_a_file_commands_the_value_of_that_row() {
    let cli = Cli::new();
    cli.write("in.csv", "t,command_deg\n0.001,5\n");
    let csv = cli.trace("black-box-1 --input-file in.csv");
    assert_eq!(csv.column("command_deg"), [5.0, 5.0]);
}

#[test]
fn the_last_row_of_the_file_is_the_last_of_the_run() {
    let cli = Cli::new();
    cli.write("in.csv", "t,command_deg\n0,1\n0.005,2\n");
    let t = cli.trace("grey-box --input-file in.csv").column("time_s");
    assert_eq!(t.last(), Some(&0.005));
}

#[test]
fn all_common_kinds_of_csv_are_read() {
    let cli = Cli::new();
    let kinds = [
        "t,command_deg\n0,1\n0.001,2",
        "\u{feff}t,command_deg\r\n0,1\r\n0.001,2\r\n",
        "# a comment\n\n t , command_deg \n\n0, 1\n# another\n 0.001,2 \n\n",
        "time_ms;command_mdeg\n0;1000\n1;2000",
        "time_s command_rad\n0 0.017453292519943295\n0.001 0.03490658503988659",
        "\"command_deg\",\"note\",\"t\"\n\"1\",\"a, \"\"b\"\"\",\"0\"\n2,,1e-3\n",
    ];
    for kind in kinds {
        cli.write("in.csv", kind);
        let csv = cli.trace("black-box-1 --input-file in.csv");
        assert_eq!(csv.column("command_deg"), [1.0, 2.0], "{kind:?}");
    }
}

#[test]
fn an_error_names_file_line_column_and_expected_value() {
    let cli = Cli::new();
    let bad: [(&[u8], &str); 9] = [
        (
            b"",
            "in.csv:1: the file is empty, expected a header with `time_s` and `command_deg`",
        ),
        (
            b"t,command_deg\n",
            "in.csv:1: no row of data, expected at least one",
        ),
        (
            b"0,1\n1,2\n",
            "in.csv:1: no column `time_s`: the columns are `0`, `1`, expected",
        ),
        (
            b"t,command\n0,1\n",
            "in.csv:1: column `command` has no unit, expected a header with `time_s` and",
        ),
        (
            b"t,command_deg\n0,NaN\n",
            "column 2 (`command_deg`) is `NaN`, expected an angle",
        ),
        (
            b"t,command_deg\n0,1e6\n",
            "`1e6`, expected an angle from -32768 to 32767 deg",
        ),
        (
            b"t,command_deg\n-1,1\n",
            "in.csv:2: column 1 (`t`) is `-1`, expected a time from 0 to",
        ),
        (
            b"t,command_deg\n1,1\n\n#\n0.5,1\n",
            "in.csv:5: t is 0.5 s after 1 s, expected times that do",
        ),
        (
            b"t,command_deg\n0,1,2\n",
            "in.csv:2: the fields are 3, expected 2 as in the header",
        ),
    ];
    for (content, message) in bad {
        cli.write("in.csv", content);
        cli.assert_error("simulate board --csv - --input-file in.csv", 2, message);
    }
    cli.write("load.csv", "t,torque_nm\n0,1000\n");
    let load = "simulate board --plant bench --csv - --load-file load.csv";
    let message =
        "load.csv:2: column 2 (`torque_nm`) is `1000`, expected a torque from -100 to 100 Nm";
    cli.assert_error(load, 2, message);
}

#[test]
fn an_unreadable_file_is_reported_with_status_1() {
    let cli = Cli::new();
    cli.assert_error(
        "simulate board --input-file none.csv",
        1,
        "cannot read none.csv: ",
    );
    cli.assert_error("simulate board --input-file .", 1, "cannot read .: ");
}

#[test]
fn two_million_rows_are_read_quickly() {
    let cli = Cli::new();
    let mut text = String::from("t,command_deg\n");
    for row in 0..2_000_000 {
        let _ = writeln!(text, "{}e-4,{}", row, row % 90);
    }
    cli.write("in.csv", text);
    let mut command = cli.actuator("simulate board --input-file in.csv --duration 0.1 --csv -");
    // It takes less than a second on an idle machine.
    command.timeout(Duration::from_secs(30)).assert().success();
}
