//! Builds the core as WebAssembly and writes it with its wrapper as one script:
//! `cargo run -p actuator-web --example script -- [FILE]`, by default `actuator.js`.

use std::env;
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use base64::prelude::{BASE64_STANDARD, Engine as _};
use cross_build::WEB_TARGET;

const CORE_JS: &str = include_str!("../core.js");

fn main() -> Result<(), Box<dyn Error>> {
    let out = env::args().nth(1).unwrap_or_else(|| "actuator.js".into());
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let wasm = fs::read(build(&root)?)?;
    let base64 = BASE64_STANDARD.encode(&wasm);
    fs::write(&out, format!("{CORE_JS}\nconst CORE = '{base64}';\n"))?;
    println!("{out}: the core has {} kB before base64", wasm.len() / 1000);
    Ok(())
}

/// Builds the library for the browser and returns its path.
fn build(root: &Path) -> Result<PathBuf, Box<dyn Error>> {
    let target = match env::var_os("CARGO_TARGET_DIR") {
        Some(target) => PathBuf::from(target),
        None => root.join("target"),
    };
    let arguments = ["build", "--profile=web", "-p=actuator-web", "--lib"];
    let arguments = [&arguments[..], &["--target", WEB_TARGET]].concat();
    cross_build::build(WEB_TARGET, &arguments, &target)?;
    Ok(target.join(WEB_TARGET).join("web/actuator_web.wasm"))
}
