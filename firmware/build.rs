//! Writes the table of the object dictionary and the storage behind it.

use std::{env, error::Error, fs, path::Path};

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed=object-dictionary.csv");
    let folder = env::var("OUT_DIR")?;
    for (file, text) in canopen_generator::actuator::rust_sources()? {
        fs::write(Path::new(&folder).join(file), text)?;
    }
    Ok(())
}
