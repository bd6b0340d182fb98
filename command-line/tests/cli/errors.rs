//! Errors of the command line.

use super::Cli;

#[test]
fn the_error_of_an_unknown_name_suggests_the_most_similar_one() {
    let cli = Cli::new();
    let bad = [
        ("simulat", "a similar subcommand exists: 'simulate'"),
        ("simulate bord", "a similar value exists: 'board'"),
        (
            "simulate board --preset consistant",
            "a similar value exists: 'consistent'",
        ),
        (
            "simulate board --input puls",
            "a similar value exists: 'pulse'",
        ),
        (
            "simulate board --plott x",
            "a similar argument exists: '--plot'",
        ),
        (
            "simulate board --set position_gian=3",
            "unknown parameter `position_gian`, did you mean `position_gain`?; expected one that \
             `actuator simulate board --plant first-order --list-parameters` prints",
        ),
        (
            "simulate board --set input.amplitude=3",
            "unknown input parameter `amplitude`, did you mean `amplitude_deg`?; expected \
             input.amplitude_deg, input.start_s, input.end_s",
        ),
        // Half of the letters agree, but not those of the first word.
        (
            "simulate board --set motor_gain=3",
            "unknown parameter `motor_gain`, did you mean `motor_gain_down`?; expected one",
        ),
        (
            "simulate board --set current_gain=3",
            "unknown parameter `current_gain`; expected one",
        ),
        // A parameter without a symbol is not found by the empty name.
        (
            "simulate board --set =3",
            "unknown parameter ``; expected one",
        ),
    ];
    for (arguments, message) in bad {
        cli.assert_error(arguments, 2, message);
    }
}

#[test]
fn a_file_of_another_kind_is_named() {
    let cli = Cli::new();
    let expected = "expected TOML, or a servo of BAM in JSON";
    for (content, kind) in [
        (&b"\x1f\x8b\x08\0"[..], "a gzip file, "),
        (b"PK\x03\x04\xff", "a zip archive or a workbook, "),
        (b"PAR1\xff", "a Parquet file, "),
        (b"\xff\xfe[\0", "text in UTF-16, "),
        (b"\xfe\xff\0[", "text in UTF-16, "),
        (b"[set]\na = 1\n\xb0", "line 3 is no text in UTF-8, "),
        (
            b"[FileInfo]\nFileName=a.dcf\n[60",
            "a DCF or EDS of CANopen, ",
        ),
    ] {
        cli.write("file", content);
        let message = format!("error: file: {kind}{expected}\n");
        for command in [
            "simulate --scenario",
            "simulate --parameters",
            "set --parameters",
            "export --to bam",
        ] {
            cli.assert_error(&format!("{command} file"), 2, &message);
        }
    }
}

#[test]
fn an_option_that_is_no_number_or_names_no_column_is_refused_with_what_it_takes() {
    let cli = Cli::new();
    for (arguments, message) in [
        ("excite ramp --rate 1e9", "expected a whole number"),
        ("excite prbs --order x", "expected a whole number"),
        ("excite sine --amplitude x", "expected a number"),
        (
            "identify run.csv --column angle=",
            "the column of the angle is empty, expected its name or number",
        ),
        (
            "identify run.csv --column angle=:rad",
            "the column of the angle is empty, expected its name or number",
        ),
    ] {
        cli.assert_error(arguments, 2, message);
    }
}

#[test]
fn a_number_beyond_all_bounds_is_shown_with_an_exponent() {
    let cli = Cli::new();
    cli.write(
        "run.csv",
        "time_s,command_deg,angle_deg\n0,0,0\n1,1,1\n2,1,1e300\n",
    );
    for arguments in [
        "simulate board --duration 1e300",
        "experiment black-box-1 --duration 1e300",
        "experiment black-box-1 --noise 1e300",
        "excite sine --amplitude 1e300",
        "move 1e300",
        "move 0 --within 1e300",
        "record --for 1e300",
        "serve --protocol sts3215 --supply-ohm 1e300",
        "identify run.csv",
    ] {
        cli.assert_error(arguments, 2, " is 1e300");
    }
}

#[test]
fn the_first_steps_without_files_of_the_user_are_commands() {
    let cli = Cli::new();
    let steps = cli.text("");
    let simulate = steps
        .lines()
        .find(|line| line.contains("actuator simulate"));
    let simulate = simulate.expect("a step").trim();
    let arguments = simulate.strip_prefix("actuator ").expect("a command");
    cli.actuator(arguments).assert().success();
    assert!(cli.read("run.html").contains("<svg"), "{simulate}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_reported_for_files_and_for_standard_output() {
    let cli = Cli::new();
    cli.assert_error(
        "simulate board --csv /dev/full",
        1,
        "cannot write /dev/full: No space",
    );
    let full = std::fs::File::options().write(true).open("/dev/full");
    let output = std::process::Command::new(assert_cmd::cargo::cargo_bin!("actuator"))
        .args(["simulate", "board", "--csv", "-"])
        .stdout(full.expect("Linux has it"))
        .output()
        .expect("the program runs");
    assert_eq!(output.status.code(), Some(1));
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        error.contains("cannot write standard output: No space"),
        "{error}"
    );
}

#[cfg(target_os = "linux")]
#[test]
fn a_file_without_end_is_refused_with_its_limit() {
    let cli = Cli::new();
    let image = "/dev/zero: it continues after 229376 bytes, expected at most 229376";
    let text = "cannot read /dev/zero: it continues after 1048576 bytes, expected at most 1048576";
    let key = "/dev/zero: no key, which has 64 hexadecimal digits in a file of at most 256 bytes";
    #[cfg(feature = "board")]
    let build = "/dev/zero: it continues after 268435456 bytes, expected at most 268435456";
    let recording = "more than 65536 bytes in a line";
    for (arguments, status, message) in [
        ("simulate --scenario /dev/zero", 1, text),
        ("simulate --parameters /dev/zero", 1, text),
        ("experiment black-box-1 --parameters /dev/zero", 1, text),
        ("mujoco --parameters /dev/zero", 1, text),
        ("set --parameters /dev/zero --bus 127.0.0.1:1", 1, text),
        ("simulate board --input-file /dev/zero", 2, recording),
        (
            "simulate board --plant bench --load-file /dev/zero",
            2,
            recording,
        ),
        ("identify /dev/zero", 2, recording),
        ("compare /dev/zero", 2, recording),
        ("image show /dev/zero", 1, image),
        ("image verify /dev/zero", 1, image),
        ("update /dev/zero --bus 127.0.0.1:1", 1, image),
        (
            "image sign /dev/zero --out a.img",
            1,
            "/dev/zero: it continues after 268435456 bytes, expected at most 268435456",
        ),
        ("image sign a.elf --out a.img --key /dev/zero", 2, key),
        ("image verify a.img --key /dev/zero", 2, key),
        (
            "fmu --out a.fmu --library /dev/full",
            1,
            "cannot read /dev/full: it continues after 268435456 bytes",
        ),
    ] {
        cli.assert_error(arguments, status, message);
    }
    #[cfg(feature = "board")]
    for (arguments, message) in [
        ("board --elf /dev/zero", build),
        ("board --elf a.elf --faults /dev/zero", text),
        ("serve --elf /dev/zero --comm-elf a.elf", build),
    ] {
        cli.assert_error(arguments, 1, message);
    }
    // The length of a file is known before it is read; of this one no byte is on the disk.
    let long = std::fs::File::create(cli.path("long.json")).expect("a file");
    long.set_len((1 << 31) + 1).expect("its length");
    let message = "cannot read long.json: it has 2147483649 bytes, expected at most 2147483648";
    cli.assert_error("identify long.json", 1, message);
}

#[test]
fn a_recording_behind_json_is_not_overwritten() {
    let cli = Cli::new();
    cli.text("simulate black-box-1 --input pulse --csv run.csv");
    let before = cli.read("run.csv");
    let message = "invalid value 'run.csv' for '--json [<FILE>]': expected a file .json, or `-`";
    cli.assert_error("identify other.csv --json run.csv", 2, message);
    assert_eq!(cli.read("run.csv"), before);
}

#[test]
fn a_plot_of_more_rows_than_fit_into_memory_is_refused() {
    let cli = Cli::new();
    let message = "the plot would have 10000000 rows, expected at most 2000000";
    cli.assert_error("simulate board --duration 10000 --plot p.svg", 2, message);
}

#[test]
fn a_chain_needs_both_programs_and_the_emulator() {
    let cli = Cli::new();
    cli.assert_error("serve --elf actuator-board", 2, "--elf needs --comm-elf");
    cli.assert_error("serve --comm-elf comm-board", 2, "--elf <FILE>");
    let two = "serve --nodes 1 --elf a --elf native --comm-elf comm-board";
    let message = "2 programs (--elf) for 1 actuators (--nodes)";
    cli.assert_error(two, 2, message);
    let (status, missing) = if cfg!(feature = "board") {
        (1, "actuator-board: ")
    } else {
        (
            2,
            "this program was built without the emulator; one that has it is built by `cargo emulate serve`",
        )
    };
    cli.assert_error(
        "serve --elf no/actuator-board --comm-elf no/comm-board",
        status,
        missing,
    );
}
