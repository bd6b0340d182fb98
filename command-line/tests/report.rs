//! The command `actuator report` as it is called.

use std::fs;

use assert_cmd::Command;
use predicates::prelude::PredicateBooleanExt as _;
use predicates::str::contains;

#[test]
fn a_page_figures_and_json_are_written_and_the_same_page_with_tables_the_next_time() {
    let folder = tempfile::tempdir().expect("a folder");
    let report = |arguments: &[&str]| {
        let mut actuator = Command::cargo_bin("actuator").expect("the program");
        let done = actuator
            .current_dir(&folder)
            .arg("report")
            .args(arguments)
            .assert();
        done.success().stderr(contains("actuator-report.html"))
    };
    let page = || fs::read(folder.path().join("actuator-report.html")).expect("the page");

    let first = report(&["--json", "-", "--figures", "figures"]);
    let json: serde_json::Value =
        serde_json::from_slice(&first.get_output().stdout).expect("nothing but JSON");
    assert_eq!(json["models"].as_array().map(Vec::len), Some(12));
    let picture = folder.path().join("figures/step-responses.svg");
    assert!(
        fs::read_to_string(picture)
            .expect("a figure")
            .starts_with("<svg ")
    );

    let first_page = page();
    report(&[]).stdout(contains("phase margin").and(contains("board on the bench")));
    assert!(page() == first_page);
    // The page and the figures, and nothing half done.
    assert_eq!(fs::read_dir(&folder).expect("the folder").count(), 2);
}
