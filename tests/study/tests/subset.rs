//! One run of the study, done again: what stands in docs/study is what the command writes.

use std::path::Path;

use study::{
    Failure,
    bench::{Controller, Load},
    claims, figures, page,
    runs::{self, INPUTS, Key, Rate},
    study::{Study, place},
};

fn committed(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/study");
    std::fs::read_to_string(folder.join(name)).expect("the study is in docs/study")
}

#[test]
fn a_run_done_again_is_the_one_of_the_study_to_the_last_bit() {
    let key = Key {
        controller: Controller::Retuned,
        load: Load::Unloaded,
        input: place("3-2-1-1"),
        run: 1,
    };
    let runs = runs::all(board_tests::runs::firmware(), &[key]).expect("the board runs");
    let row = page::run_row(&runs[0]);
    let found = committed("runs.csv").lines().any(|line| line == row);
    assert!(
        found,
        "`{row}` is not in runs.csv: cargo run --release --bin study -- --out docs/study"
    );
    let study = Study::of(runs).expect("it can be fitted");
    let fit = study
        .fit(1, Rate::Hz250, "3-2-1-1", 0)
        .expect("it was fitted");
    assert!(fit.quality.fit_percent > 80.0, "{:?}", fit.quality);
    // What is missing is left out or said, never made up.
    assert!(matches!(claims::all(&study), Err(Failure::Incomplete)));
    assert!(figures::all(&study).expect("no figure").is_empty());
}

#[test]
fn the_page_names_every_run_fit_and_figure_that_is_there() {
    let (page, fits) = (committed("README.md"), committed("fits.csv"));
    assert_eq!(committed("runs.csv").lines().count(), 1 + Key::all().len());
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
