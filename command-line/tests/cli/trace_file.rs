//! `actuator simulate --out`: the files that it writes, and those that it refuses.

use predicates::prelude::*;

use super::Cli;

#[test]
fn each_file_has_the_format_of_its_name_in_addition_to_the_summary() {
    let cli = Cli::new();
    let mut run = cli.actuator("simulate board --duration 0.1 --out a.csv --out b.mat --out c.csv");
    run.assert()
        .success()
        .stdout(predicate::str::contains("rate_command_deg_s"))
        .stderr("trace: a.csv\ntrace: b.mat\ntrace: c.csv\n");
    assert!(cli.read("a.csv") == cli.text("simulate board --duration 0.1 --csv -"));
    assert!(cli.read("c.csv") == cli.read("a.csv"));
    let mat = std::fs::read(cli.path("b.mat")).expect("the file was written");
    assert!(mat.starts_with(b"MATLAB 5.0 MAT-file"));
    // A hundred rows of ten columns, and the description of the columns.
    assert!((8000..20_000).contains(&mat.len()), "{}", mat.len());
    let folder = std::fs::read_dir(cli.path(".")).expect("the folder");
    assert_eq!(folder.count(), 3, "nothing half done");
}

#[test]
fn csv_on_standard_output_can_be_combined_with_files() {
    let cli = Cli::new();
    let mut run = cli.actuator("simulate grey-box --csv - --out run.mat --plot run.svg");
    let assert = run
        .assert()
        .success()
        .stderr("trace: run.mat\nplot: run.svg\n");
    assert.stdout(predicate::str::starts_with("time_s,command_deg,"));
}

#[test]
fn a_file_name_without_a_format_or_given_twice_is_refused_before_the_run() {
    let cli = Cli::new();
    let expected = "expected a name that ends in .csv, .mat or .parquet";
    let bad = [
        ("--out run.xlsx", format!("--out is run.xlsx, {expected}")),
        ("--out run", format!("--out is run, {expected}")),
        ("--out -", format!("--out is -, {expected}")),
        ("--out a.mat --out .", format!("--out is ., {expected}")),
        (
            "--out a.mat --out a.mat",
            "--out and --out both write a.mat".into(),
        ),
        (
            "--csv a.csv --out ./a.csv",
            "--csv and --out both write ./a.csv".into(),
        ),
    ];
    for (options, message) in bad {
        cli.assert_error(&format!("simulate board {options}"), 2, &message);
        assert!(!cli.path("a.mat").exists() && !cli.path("a.mat.part").exists());
    }
}

#[test]
fn a_trace_beyond_the_limit_of_a_mat_file_is_refused_before_the_run() {
    let cli = Cli::new();
    cli.assert_error(
        "simulate black-box-1 --csv - --duration 10000000 --every 1 --out run.mat",
        2,
        "run.mat would have 200000000000 rows, expected at most 33538047: a variable of a MAT file \
         holds 2 GiB",
    );
    assert!(!cli.path("run.mat.part").exists());
}

#[cfg(unix)]
#[cfg(not(feature = "parquet"))]
#[test]
fn a_build_without_parquet_names_the_feature() {
    let cli = Cli::new();
    let message = "run.parquet: this program was built without the feature `parquet`, expected \
                   `cargo build --release --features parquet`";
    cli.assert_error("simulate board --csv - --out run.parquet", 2, message);
}

#[cfg(feature = "parquet")]
#[test]
fn a_build_with_parquet_writes_it() {
    let cli = Cli::new();
    cli.text("simulate board --duration 0.1 --out run.parquet");
    let file = std::fs::read(cli.path("run.parquet")).expect("the file was written");
    assert!(file.starts_with(b"PAR1") && file.ends_with(b"PAR1"));
}
