//! Writes the documents that are generated from the object dictionary of the actuator's board:
//!
//! ```text
//! cargo run -p canopen-generator
//! ```

use std::error::Error;
use std::fs;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    for (path, text) in canopen_generator::actuator::documents()? {
        fs::write(root.join(path), text)?;
        println!("{path}");
    }
    Ok(())
}
