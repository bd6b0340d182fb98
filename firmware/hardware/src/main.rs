//! Checks the design of the boards, and writes what is generated from it:
//!
//! ```text
//! cargo run -p board-design            # check, then write
//! cargo run -p board-design -- check   # check only
//! ```

use std::error::Error;
use std::fs;
use std::path::Path;

use board_design::{Design, check, write};

fn main() -> Result<(), Box<dyn Error>> {
    let design = Design::read()?;
    let findings = check::check(&design);
    for finding in &findings {
        eprintln!("{finding}");
    }
    if !findings.is_empty() {
        return Err(format!("{} errors of the design", findings.len()).into());
    }
    println!(
        "{} parts, {} nets: no errors",
        design.parts.len(),
        design.nets.len()
    );
    if std::env::args().nth(1).as_deref() == Some("check") {
        return Ok(());
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    for (path, text) in write::files(&design, &root)? {
        let path = root.join(path);
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder)?;
        }
        fs::write(&path, text)?;
    }
    Ok(())
}
