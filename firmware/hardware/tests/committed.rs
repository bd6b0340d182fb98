//! The design is sound, and the committed files are those that it generates.

use std::fs;
use std::path::Path;

use board_design::{Design, check, write};

#[test]
fn the_check_finds_nothing_in_what_stands() {
    let findings = check::check(&Design::read().expect("valid files"));
    assert_eq!(findings, []);
}

#[test]
fn tables_schematic_list_of_parts_figures_and_pins_are_those_of_the_design() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let design = Design::read().expect("valid files");
    for (path, text) in write::files(&design, &root).expect("the document has its markers") {
        let committed = fs::read_to_string(root.join(path)).unwrap_or_default();
        assert!(
            committed == text,
            "{path} is out of date: cargo run -p board-design"
        );
    }
}
