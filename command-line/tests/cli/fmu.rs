//! `actuator fmu`.

use predicates::str::contains;

use super::Cli;

#[test]
fn the_fmu_contains_the_library_of_this_build() {
    let cli = Cli::new();
    cli.actuator("fmu --out a.fmu --plant bench --set P=9")
        .assert()
        .success();
    let unit = std::fs::read(cli.path("a.fmu")).expect("the file is there");
    // The directory of a zip file lists the names as they are.
    for name in [
        "modelDescription.xml",
        "documentation/index.html",
        "binaries/linux64/actuator_board_bench.so",
    ] {
        let is_listed = unit.windows(name.len()).any(|w| w == name.as_bytes());
        assert!(is_listed || cfg!(not(target_os = "linux")), "{name}");
    }
}

#[test]
fn inconsistent_options_are_refused_before_a_file_is_written() {
    let cli = Cli::new();
    cli.write("text.so", "no library");
    for (options, expected) in [
        ("--model grey-box --plant bench", "`grey-box` has no plant"),
        ("--plant bench --preset asymmetric", "the plant is `bench`"),
        ("--set P=-1", "position_gain is -1"),
        ("--set input.amplitude_deg=1", "input.amplitude_deg"),
        (
            "--set position_min_deg=5 --set position_max_deg=-5",
            "position_m",
        ),
        ("--library text.so", "text.so is not a shared library"),
    ] {
        cli.actuator(&format!("fmu --out a.fmu {options}"))
            .assert()
            .code(2)
            .stderr(contains(expected));
        assert!(!cli.path("a.fmu").exists(), "{options}");
    }
    cli.actuator("fmu --out a.fmu --library nowhere.so")
        .assert()
        .code(1);
}
