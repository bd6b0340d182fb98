//! Puts the shared libraries that `ACTUATOR_FMU_LIBRARIES` names into the program, so that a copy
//! of it alone can write FMUs. `bindings/package` sets the variable.

use std::{env, fs, io, path::Path};

const VARIABLE: &str = "ACTUATOR_FMU_LIBRARIES";

fn main() -> io::Result<()> {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed={VARIABLE}");
    let mut source = String::from("&[");
    for path in env::split_paths(&env::var_os(VARIABLE).unwrap_or_default()) {
        // An empty variable is one empty path.
        if path.as_os_str().is_empty() {
            continue;
        }
        println!("cargo::rerun-if-changed={}", path.display());
        source += &format!("({path:?}, include_bytes!({path:?})),");
    }
    source += "]";
    let out = env::var_os("OUT_DIR").unwrap_or_default();
    fs::write(Path::new(&out).join("fmu_libraries.rs"), source)
}
