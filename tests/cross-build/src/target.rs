//! Rust targets of the active toolchain.

use std::{
    fs::{self, File},
    path::PathBuf,
    process::{Command, Output},
};

use crate::{Error, workspace};

/// Adds a target to the active toolchain where it is missing.
///
/// # Errors
/// If the target is missing and rustup cannot add it: there is no rustup, or no network.
pub fn add_target(target: &str) -> Result<(), Error> {
    // Test programs run side by side; rustup must not add the same target twice at once.
    let _lock = lock()?;
    if is_installed(target)? {
        return Ok(());
    }
    let output = run("rustup", &["target", "add", target])?;
    if output.status.success() && is_installed(target)? {
        return Ok(());
    }
    Err(Error::Target {
        target: target.to_owned(),
        reason: String::from_utf8_lossy(&output.stderr).trim().to_owned(),
    })
}

fn is_installed(target: &str) -> Result<bool, Error> {
    let output = run("rustc", &["--print", "target-libdir", "--target", target])?;
    let folder = PathBuf::from(String::from_utf8_lossy(&output.stdout).trim());
    Ok(output.status.success() && folder.is_dir())
}

fn run(program: &str, arguments: &[&str]) -> Result<Output, Error> {
    // In the workspace's folder rustup finds rust-toolchain.toml.
    let mut command = Command::new(program);
    command.args(arguments).current_dir(workspace());
    command.output().map_err(|source| Error::Start {
        command: format!("{program} {}", arguments.join(" ")),
        source,
    })
}

/// A lock that ends with the returned file.
fn lock() -> Result<File, Error> {
    let folder = workspace().join("target");
    let path = folder.join("targets.lock");
    fs::create_dir_all(&folder)
        .and_then(|()| File::create(&path))
        .and_then(|file| file.lock().map(|()| file))
        .map_err(|source| Error::Lock { path, source })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_target_of_this_pc_is_there() {
        let host = run("rustc", &["-vV"]).expect("rustc runs").stdout;
        let host = String::from_utf8(host).expect("UTF-8");
        let triple = host.lines().find_map(|line| line.strip_prefix("host: "));
        add_target(triple.expect("a host")).expect("a toolchain has its own target");
    }

    #[test]
    fn a_target_that_does_not_exist_is_named_in_the_error() {
        let error = add_target("no-such-target").expect_err("there is no such target");
        let text = error.to_string();
        assert!(text.contains("no-such-target"), "{text}");
    }
}
