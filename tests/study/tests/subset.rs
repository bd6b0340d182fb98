//! The files in docs/study agree with the output of the command; one run is repeated.

use std::path::Path;

use study::{
    Failure, claims, figures, page,
    runs::{self, INPUTS, RunKey, SampleRate},
    study::{Study, input_index},
    test_bench::{Controller, Load},
};

fn committed(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/study");
    std::fs::read_to_string(folder.join(name)).expect("a file of docs/study")
}

#[test]
fn a_repeated_run_is_bit_exact() {
    let key = RunKey {
        controller: Controller::Retuned,
        load: Load::Unloaded,
        input: input_index("3-2-1-1"),
        run: 1,
    };
    let runs = runs::all(board_tests::program::firmware(), &[key]).expect("the board runs");
    let row = page::run_row(&runs[0]);
    let found = committed("runs.csv").lines().any(|line| line == row);
    assert!(
        found,
        "`{row}` is not in runs.csv: cargo run --release --bin study -- --out docs/study"
    );
    let study = Study::of(runs).expect("the runs can be fitted");
    let fit = study
        .fit(1, SampleRate::Hz250, "3-2-1-1", 0)
        .expect("the fit of the run");
    assert!(fit.quality.fit_percent > 80.0, "{:?}", fit.quality);
    // Claims and figures without runs are reported or omitted.
    assert!(matches!(claims::all(&study), Err(Failure::Incomplete)));
    assert!(figures::all(&study).expect("no figure").is_empty());
}

#[test]
fn the_committed_page_has_the_texts_of_the_template() {
    let study = Study {
        runs: Vec::new(),
        fits: std::collections::BTreeMap::new(),
        verdicts: Vec::new(),
    };
    let (committed, files) = (committed("README.md"), page::files(&study, &[]));
    for line in files[0].1.lines().filter(|line| !line.ends_with("– |")) {
        assert!(
            committed.lines().any(|found| found == line),
            "`{line}` is not in docs/study/README.md"
        );
    }
}

#[test]
fn the_page_contains_every_run_fit_and_figure() {
    let (page, fits) = (committed("README.md"), committed("fits.csv"));
    assert_eq!(
        committed("runs.csv").lines().count(),
        1 + RunKey::all().len()
    );
    for input in INPUTS {
        assert!(page.contains(input) && fits.contains(input), "{input}");
    }
    let figures = page.split("](figure-").skip(1);
    let names: Vec<&str> = figures.filter_map(|rest| rest.split(')').next()).collect();
    assert!(names.len() >= 15);
    for name in names {
        assert!(
            committed(&format!("figure-{name}")).contains("<svg"),
            "{name}"
        );
    }
}

#[test]
fn nine_of_ten_estimates_from_two_inputs_agree_within_two_standard_errors() {
    let page = committed("README.md");
    let all = page.lines().find(|line| line.starts_with("| all |"));
    let cells: Vec<&str> = all.expect("a row of all pairs").split('|').collect();
    let percent: f64 = cells[6].trim().parse().expect("a share");
    assert!(percent >= 90.0, "{percent} %");
}
