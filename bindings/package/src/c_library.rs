//! The C library: header, static and shared library, and files for pkg-config and CMake.

use std::{
    fs,
    os::unix::fs::symlink,
    path::{Path, PathBuf},
    process::Command,
};

use crate::{
    copy,
    error::{Error, at},
    tools::{LINUX, Tools, run},
};

/// The version of the release.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The version of the interface, which the header states: it is in the SONAME.
const HEADER: &str = include_str!("../../c/include/actuator.h");

const FILES: [(&str, &str); 3] = [
    (
        "lib/pkgconfig/actuator_c.pc",
        include_str!("../templates/actuator_c.pc"),
    ),
    (
        "lib/cmake/actuator_c/actuator_c-config.cmake",
        include_str!("../templates/actuator_c-config.cmake"),
    ),
    (
        "lib/cmake/actuator_c/actuator_c-config-version.cmake",
        include_str!("../templates/actuator_c-config-version.cmake"),
    ),
];

const LIBRARY: [&str; 4] = ["-p", "actuator-c", "--lib", "--crate-type"];

/// Builds the static library: of the standard library only what is called.
pub fn archive(tools: &Tools, target: &str) -> Result<PathBuf, Error> {
    let lean = ["staticlib", "--config", "profile.release.lto='fat'"];
    let built = tools.build(target, &[&LIBRARY[..], &lean].concat(), &[], &[])?;
    Ok(built.join("libactuator_c.a"))
}

/// Makes the folder `c`, which can be copied below `/usr/local` or any other prefix.
pub fn make(tools: &Tools, out: &Path) -> Result<(), Error> {
    let folder = out.join("c");
    let of_interface = format!("libactuator_c.so.{}", abi_version());
    let soname = format!("-Wl,-soname,{of_interface}");
    let shared = [&LIBRARY[..], &["cdylib"]].concat();
    let built = tools.build(LINUX, &shared, &[&soname], &[])?;
    let whole = format!("libactuator_c.so.{VERSION}");
    copy(
        &built.join("libactuator_c.so"),
        &folder.join("lib").join(&whole),
    )?;
    let archive = folder.join("lib/libactuator_c.a");
    copy(&self::archive(tools, LINUX)?, &archive)?;
    // Without the debug information of the standard library.
    run(Command::new("strip").arg("--strip-debug").arg(&archive))?;
    for (name, target) in [
        (of_interface.as_str(), whole.as_str()),
        ("libactuator_c.so", &of_interface),
    ] {
        let link = folder.join("lib").join(name);
        // One of an older release.
        let _: std::io::Result<()> = fs::remove_file(&link);
        symlink(target, &link).map_err(at(&link))?;
    }
    let header = folder.join("include/actuator.h");
    fs::create_dir_all(folder.join("include")).map_err(at(&folder))?;
    fs::write(&header, HEADER).map_err(at(&header))?;
    for (name, template) in FILES {
        let place = folder.join(name);
        let parent = place.parent().unwrap_or(&folder);
        fs::create_dir_all(parent).map_err(at(parent))?;
        let text = template
            .replace("@VERSION@", VERSION)
            .replace("@ABI_VERSION@", abi_version());
        fs::write(&place, text).map_err(at(&place))?;
    }
    Ok(())
}

/// `ACTUATOR_ABI_VERSION` of the header.
fn abi_version() -> &'static str {
    let line = HEADER
        .lines()
        .find_map(|line| line.strip_prefix("#define ACTUATOR_ABI_VERSION "));
    line.map_or("0", str::trim)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_version_of_the_interface_is_a_number_above_zero() {
        assert!(
            abi_version()
                .parse::<u32>()
                .is_ok_and(|version| version > 0)
        );
    }
}
