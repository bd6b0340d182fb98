//! The wheel of the Python package: one for all versions of Python from 3.9.

use std::{fs, path::Path};

use crate::{
    error::{Error, at},
    tools::{LINUX, Tools, run},
};

/// The greatest size of the wheel, bytes.
const MOST_BYTES: u64 = 4_000_000;

/// Makes the wheel in place of an older one.
pub fn make(tools: &Tools, out: &Path) -> Result<(), Error> {
    for old in wheels(out)? {
        fs::remove_file(&old).map_err(at(&old))?;
    }
    cross_build::add_target(LINUX)?;
    let mut maturin = tools.command("maturin");
    run(maturin
        .args(["build", "--quiet", "--locked", "--zig", "--target", LINUX])
        .args(["--compatibility", "manylinux2014"])
        .args(["--manifest-path", "bindings/python/Cargo.toml", "--out"])
        .arg(out))?;
    for path in wheels(out)? {
        let bytes = fs::metadata(&path).map_err(at(&path))?.len();
        if bytes > MOST_BYTES {
            let most = MOST_BYTES;
            return Err(Error::TooLarge { path, bytes, most });
        }
    }
    Ok(())
}

fn wheels(out: &Path) -> Result<Vec<std::path::PathBuf>, Error> {
    let entries = fs::read_dir(out).map_err(at(out))?;
    let paths = entries.map(|entry| Ok(entry.map_err(at(out))?.path()));
    let paths = paths.collect::<Result<Vec<_>, Error>>()?;
    let is_wheel = |path: &std::path::PathBuf| path.extension().is_some_and(|e| e == "whl");
    Ok(paths.into_iter().filter(is_wheel).collect())
}
