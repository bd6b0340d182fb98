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
fn the_error_of_an_invalid_value_names_the_expected_ones() {
    let cli = Cli::new();
    let bad = [
        (
            "--duration 0",
            "duration is 0, expected more than 0 and at most 10,000,000 s",
        ),
        ("--duration -1", "duration is -1, expected more than 0"),
        ("--duration nan", "duration is NaN, expected more than 0"),
        ("--duration inf", "duration is inf, expected more than 0"),
        (
            "--duration 1e9",
            "duration is 1000000000, expected more than 0 and at most",
        ),
        (
            "--duration soon",
            "invalid value 'soon' for '--duration <SECONDS>'",
        ),
        ("--every 0", "every is 0, expected at least 1 tick"),
        ("--every -1", "invalid value '-1' for '--every <N>'"),
        ("--every 1.5", "invalid value '1.5' for '--every <N>'"),
        ("--seed -1", "invalid value '-1' for '--seed <SEED>'"),
        ("--pwm often", "possible values: average, switched"),
        (
            "--set P",
            "invalid value 'P' for '--set <NAME=VALUE>': expected NAME=VALUE",
        ),
        ("--set P=", "`` is not a number"),
        ("--set P=1,5", "`1,5` is not a number"),
        (
            "--set P=-3",
            "parameter position_gain is -3, expected a number from 0 to 500 1/s",
        ),
        (
            "--set P=nan",
            "parameter position_gain is NaN, expected a number from 0 to 500 1/s",
        ),
        (
            "--set P=1e300",
            "parameter position_gain is 1e300, expected",
        ),
        (
            "--set duty_slew_pct_s=-inf",
            "parameter duty_slew_pct_s is -inf, expected a number",
        ),
        (
            "--set encoder_direction=0",
            "encoder_direction is 0, expected 1 or -1",
        ),
        (
            "--input chirp --set input.duration_s=0",
            "parameter input.duration_s is 0, expected a number from 0.001 to 3600 s",
        ),
        (
            "--set position_min_deg=10 --set position_max_deg=0",
            "position_min_deg is above position_max_deg",
        ),
        (
            "--plot p.png",
            "--plot is p.png, expected a name that ends in .svg or .html",
        ),
    ];
    for (options, message) in bad {
        // No header is written before all arguments have been checked.
        cli.assert_error(&format!("simulate board --csv - {options}"), 2, message);
    }
}

#[test]
fn inconsistent_options_are_refused_with_the_reason() {
    let cli = Cli::new();
    cli.write("in.csv", "t,command_deg\n0,1\n");
    let bad = [
        (
            "board --preset as-printed",
            "preset `as-printed` is for grey-box, not for board: G and F as printed, duty in the \
             paper's unit and unlimited, which no board can realise",
        ),
        (
            "black-box-1 --preset asymmetric",
            "is for grey-box and board, not for black-box-1",
        ),
        (
            "board --plant bench --preset asymmetric",
            "preset `asymmetric` sets parameters of the plant `first-order`; the plant is `bench`",
        ),
        (
            "grey-box --plant bench",
            "`plant` applies to the model `board`, `grey-box` has no plant",
        ),
        (
            "board --load-file in.csv",
            "a load file applies to the plant `bench`",
        ),
        (
            "board --input sine --input-file in.csv",
            "cannot be used with '--input-file <FILE>'",
        ),
        (
            "board --input-file in.csv --set input.f=1",
            "`input.f` is set, but an input file has no parameters",
        ),
        (
            "",
            "no model, expected one of black-box-1, black-box-2, grey-box, board",
        ),
        ("board --json", "--list-parameters"),
    ];
    for (arguments, message) in bad {
        cli.assert_error(&format!("simulate {arguments}"), 2, message);
    }
}

#[test]
fn a_file_that_cannot_be_written_is_named_with_status_1() {
    let cli = Cli::new();
    let bad = [
        (
            "simulate board --csv none/out.csv",
            "cannot write none/out.csv: ",
        ),
        ("simulate board --csv .", "cannot write .: "),
        (
            "simulate board --csv out.csv --plot none/p.svg",
            "cannot write none/p.svg: ",
        ),
        ("tune --json --plot none/p.svg", "cannot write none/p.svg: "),
    ];
    for (arguments, message) in bad {
        let assert = cli.actuator(arguments).assert().code(1);
        let error = String::from_utf8_lossy(&assert.get_output().stderr).into_owned();
        assert!(error.contains(message), "{arguments}\n{error}");
    }
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
fn a_plot_of_more_rows_than_fit_into_memory_is_refused() {
    let cli = Cli::new();
    let message = "the plot would have 10000000 rows, expected at most 2000000";
    cli.assert_error("simulate board --duration 10000 --plot p.svg", 2, message);
}

#[test]
fn a_chain_needs_both_programs_and_the_emulator() {
    let cli = Cli::new();
    cli.assert_error("serve --elf actuator-board", 2, "--comm-elf <FILE>");
    cli.assert_error("serve --comm-elf comm-board", 2, "--elf <FILE>");
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
