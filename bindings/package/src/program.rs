//! The program `actuator`, with the libraries of its FMUs inside, and the FMUs.

use std::{
    env,
    path::{Path, PathBuf},
    process::Command,
};

use crate::{
    copy,
    error::{Error, at},
    tools::{LINUX, Tools, WINDOWS, run},
};

/// The FMUs with the options that `actuator fmu` makes them by.
const FMUS: [(&str, &[&str]); 5] = [
    ("board", &[]),
    ("bench", &["--plant", "bench"]),
    ("grey-box", &["--model", "grey-box"]),
    ("black-box-1", &["--model", "black-box-1"]),
    ("black-box-2", &["--model", "black-box-2"]),
];

/// The program in the release.
pub fn place(out: &Path) -> PathBuf {
    out.join("actuator")
}

/// Makes the program and the FMUs.
pub fn make(tools: &Tools, out: &Path) -> Result<(), Error> {
    let library = ["-p", "actuator-fmu", "--lib", "--crate-type", "cdylib"];
    let linux = tools.build(LINUX, &library, &[], &[])?;
    let windows = tools.build(WINDOWS, &library, &[], &[])?;
    let libraries = [
        linux.join("libactuator_fmu.so"),
        windows.join("actuator_fmu.dll"),
    ];
    let libraries = env::join_paths(&libraries).unwrap_or_default();
    let program = ["-p", "actuator", "--bin", "actuator", "--features=formats"];
    let variables = [("ACTUATOR_FMU_LIBRARIES", Path::new(&libraries))];
    let built = tools.build(LINUX, &program, &[], &variables)?;
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
