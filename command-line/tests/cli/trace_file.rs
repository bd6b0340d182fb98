//! `actuator simulate --out`: which files it writes, and which it refuses.

use predicates::prelude::*;

use super::Desk;

#[test]
fn each_file_is_written_as_its_name_says_beside_the_summary() {
    let desk = Desk::new();
    let mut run =
        desk.actuator("simulate board --duration 0.1 --out a.csv --out b.mat --out c.csv");
    run.assert()
        .success()
        .stdout(predicate::str::contains("rate_command_deg_s"))
        .stderr("trace: a.csv\ntrace: b.mat\ntrace: c.csv\n");
    assert!(desk.read("a.csv") == desk.text("simulate board --duration 0.1 --csv -"));
    assert!(desk.read("c.csv") == desk.read("a.csv"));
    let mat = std::fs::read(desk.path("b.mat")).expect("the file was written");
    assert!(mat.starts_with(b"MATLAB 5.0 MAT-file"));
    // A hundred rows of ten columns, and what they are.
    assert!((8000..20_000).contains(&mat.len()), "{}", mat.len());
    let folder = std::fs::read_dir(desk.path(".")).expect("the folder");
    assert_eq!(folder.count(), 3, "nothing half done");
}

#[test]
fn standard_output_takes_csv_beside_files() {
    let desk = Desk::new();
    let mut run = desk.actuator("simulate grey-box --csv - --out run.mat --plot run.svg");
    let assert = run
        .assert()
        .success()
        .stderr("trace: run.mat\nplot: run.svg\n");
    assert.stdout(predicate::str::starts_with("t,command,"));
}

#[test]
fn each_run_writes_the_same_bytes() {
    let desk = Desk::new();
    let run = |name: &str| {
        desk.text(&format!(
            "simulate board --plant bench --duration 0.1 --out {name}"
        ));
        std::fs::read(desk.path(name)).expect("the file was written")
    };
    assert!(run("one.mat") == run("two.mat"));
}

#[test]
fn a_name_that_says_no_format_or_stands_twice_is_refused_before_the_run() {
    let desk = Desk::new();
    let expected = "expected a name that ends in .csv, .mat or .parquet";
    let bad = [
        ("--out run.xlsx", format!("--out is run.xlsx, {expected}")),
        ("--out run", format!("--out is run, {expected}")),
        ("--out -", format!("--out is -, {expected}")),
        ("--out a.mat --out .", format!("--out is ., {expected}")),
        ("--out a.mat --out a.mat", "a.mat is written twice".into()),
        (
            "--csv a.csv --out ./a.csv",
            "./a.csv is written twice".into(),
        ),
    ];
    for (options, message) in bad {
        desk.assert_error(&format!("simulate board {options}"), 2, &message);
        assert!(!desk.path("a.mat").exists() && !desk.path("a.mat.part").exists());
    }
}

#[test]
fn a_trace_beyond_the_limit_of_a_mat_file_is_refused_before_the_run() {
    let desk = Desk::new();
    desk.assert_error(
        "simulate black-box-1 --csv - --duration 10000000 --every 1 --out run.mat",
        2,
        "run.mat would have 200000000000 rows, expected at most 33538047: a variable of a MAT file \
         holds 2 GiB",
    );
    assert!(!desk.path("run.mat.part").exists());
}

#[test]
fn a_file_that_cannot_be_written_leaves_neither_half_nor_the_others() {
    let desk = Desk::new();
    desk.write("a.csv", "old\n");
    let arguments = "simulate board --out a.csv --out none/b.mat";
    desk.assert_error(arguments, 1, "cannot write none/b.mat: No such file");
    assert_eq!(desk.read("a.csv"), "old\n");
    assert!(!desk.path("a.csv.part").exists());
}

#[cfg(unix)]
#[test]
fn a_run_that_is_killed_leaves_the_old_file() {
    let desk = Desk::new();
    desk.write("run.csv", "old\n");
    let mut run = std::process::Command::new(assert_cmd::cargo::cargo_bin!("actuator"))
        .args("simulate board --duration 1e6 --every 1 --csv run.csv".split(' '))
        .current_dir(desk.path("."))
        .spawn()
        .expect("the program starts");
    let half = desk.path("run.csv.part");
    let begun = || std::fs::metadata(&half).is_ok_and(|file| file.len() > 0);
    while !begun() && run.try_wait().expect("it is a child").is_none() {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    run.kill().expect("it still runs");
    run.wait().expect("it ends");
    assert_eq!(desk.read("run.csv"), "old\n");
}

#[cfg(not(feature = "parquet"))]
#[test]
fn a_build_without_parquet_names_the_feature() {
    let desk = Desk::new();
    let message = "run.parquet: this program was built without the feature `parquet`, expected \
                   `cargo build --release --features parquet`";
    desk.assert_error("simulate board --csv - --out run.parquet", 2, message);
}

#[cfg(feature = "parquet")]
#[test]
fn a_build_with_parquet_writes_it() {
    let desk = Desk::new();
    desk.text("simulate board --duration 0.1 --out run.parquet");
    let file = std::fs::read(desk.path("run.parquet")).expect("the file was written");
    assert!(file.starts_with(b"PAR1") && file.ends_with(b"PAR1"));
}
