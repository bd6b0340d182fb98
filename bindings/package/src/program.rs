//! The program `actuator`, with the libraries of its FMUs inside, and the FMUs; and the same
//! program for other systems.

use std::{
    env,
    path::{Path, PathBuf},
    process::Command,
};

use crate::{
    copy,
    error::{Error, at},
    tools::{LINUX, MUSL, MUSL_ARM, Tools, WINDOWS, run},
};

/// The FMUs with the options that `actuator fmu` makes them by.
const FMUS: [(&str, &[&str]); 5] = [
    ("board", &[]),
    ("bench", &["--plant", "bench"]),
    ("grey-box", &["--model", "grey-box"]),
    ("black-box-1", &["--model", "black-box-1"]),
    ("black-box-2", &["--model", "black-box-2"]),
];

/// The features of the released program: recordings in all formats, and the emulated boards.
pub const FEATURES: &str = "actuator/board,actuator/formats";

/// The program in the release.
pub fn place(out: &Path) -> PathBuf {
    out.join("actuator")
}

/// Makes the program and the FMUs.
pub fn make(tools: &Tools, out: &Path) -> Result<(), Error> {
    let built = build(tools, LINUX)?;
    copy(&built.join("actuator"), &place(out))?;
    for version in ["2", "3"] {
        let folder = out.join(format!("fmi{version}"));
        std::fs::create_dir_all(&folder).map_err(at(&folder))?;
        for (name, options) in FMUS {
            let file = folder.join(format!("{name}.fmu"));
            let mut command = Command::new(place(out));
            command.args(["fmu", "--fmi", version, "--out"]).arg(file);
            run(command.args(options))?;
        }
    }
    Ok(())
}

/// Makes the program for any Linux on x86-64, which needs no library of the system.
pub fn make_static(tools: &Tools, out: &Path) -> Result<(), Error> {
    let built = build(tools, MUSL)?;
    copy(&built.join("actuator"), &out.join("actuator-static"))
}

/// Makes the program for any Linux on ARM.
pub fn make_arm(tools: &Tools, out: &Path) -> Result<(), Error> {
    let built = build(tools, MUSL_ARM)?;
    copy(&built.join("actuator"), &out.join("actuator-aarch64"))
}

/// Makes the program for Windows.
pub fn make_windows(tools: &Tools, out: &Path) -> Result<(), Error> {
    let built = build(tools, WINDOWS)?;
    copy(&built.join("actuator.exe"), &out.join("actuator.exe"))
}

/// Builds the program for a target, with the libraries of FMUs for Linux and Windows.
fn build(tools: &Tools, target: &str) -> Result<PathBuf, Error> {
    let library = ["-p", "actuator-fmu", "--lib", "--crate-type", "cdylib"];
    let linux = tools.build(LINUX, &library, &[], &[])?;
    let windows = tools.build(WINDOWS, &library, &[], &[])?;
    let libraries = [
        linux.join("libactuator_fmu.so"),
        windows.join("actuator_fmu.dll"),
    ];
    // The separator is that of this computer, on which the build script reads it.
    let libraries = env::join_paths(&libraries).unwrap_or_default();
    // The emulator's crate declares a newer compiler than it needs.
    let program = [
        "-p",
        "actuator",
        "--bin",
        "actuator",
        "--features",
        FEATURES,
        "--ignore-rust-version",
    ];
    let variables = [("ACTUATOR_FMU_LIBRARIES", Path::new(&libraries))];
    tools.build(target, &program, &[], &variables)
}
