//! What is in the tree is what comes from the source.

use std::fs;
use std::path::Path;

use canopen_generator::actuator::{SOURCE, files};

#[test]
fn table_eds_and_documentation_are_those_of_the_source() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let source = fs::read_to_string(root.join(SOURCE)).expect("the source");
    for (path, text) in files(&source).expect("a sound source") {
        let committed = fs::read_to_string(root.join(path)).unwrap_or_default();
        assert!(
            committed == text,
            "{path} is out of date: cargo run -p canopen-generator"
        );
    }
}
