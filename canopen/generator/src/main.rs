//! Makes what comes from the object dictionary of the actuator's board:
//!
//! ```text
//! cargo run -p canopen-generator
//! ```

use std::error::Error;
use std::fs;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let source = fs::read_to_string(root.join(canopen_generator::actuator::SOURCE))?;
    for (path, text) in canopen_generator::actuator::files(&source)? {
        fs::write(root.join(path), text)?;
        println!("{path}");
    }
    Ok(())
}
