//! The report of the simulator, and the script with the actuator for other pages.

use std::{fs, path::Path, process::Command};

use crate::{
    error::{Error, at},
    program,
    tools::{Tools, run},
};

/// Makes both.
pub fn make(_: &Tools, out: &Path) -> Result<(), Error> {
    let folder = out.join("pages");
    fs::create_dir_all(&folder).map_err(at(&folder))?;
    let mut report = Command::new(program::place(out));
    run(report
        .args(["report", "--out"])
        .arg(folder.join("actuator-report.html"))
        .stdout(std::process::Stdio::null()))?;
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut script = Command::new(cargo);
    run(script
        .current_dir(cross_build::workspace())
        .args(["run", "--quiet", "--release", "--locked"])
        .args(["-p", "actuator-web", "--example", "script", "--"])
        .arg(folder.join("actuator.js")))
}
