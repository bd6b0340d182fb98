//! The committed files are those that the generator writes.

use std::fs;
use std::path::Path;

use canopen_generator::actuator::documents;

#[test]
fn eds_and_documentation_are_those_of_the_source() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    for (path, text) in documents().expect("a valid source") {
        let committed = fs::read_to_string(root.join(path)).unwrap_or_default();
        assert!(
            committed == text,
            "{path} is out of date: cargo run -p canopen-generator"
        );
    }
}
