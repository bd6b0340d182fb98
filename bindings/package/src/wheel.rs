//! The wheel of the Python package, one for all versions of Python from 3.9, with the plugin of
//! MuJoCo.

use std::{
    fs,
    path::{Path, PathBuf},
};

use crate::{
    c_library,
    error::{Error, at},
    tools::{GLIBC, LINUX, Tools, run},
};

/// The greatest size of the wheel, bytes.
const MOST_BYTES: u64 = 4_000_000;

/// The version of MuJoCo that the plugin is linked with.
const MUJOCO: &str = "4.0.0";

/// The name of the plugin before the version.
const PLUGIN: &str = "libsmart_actuator-mujoco-";

/// Makes the wheel in place of an older one.
pub fn make(tools: &Tools, out: &Path) -> Result<(), Error> {
    for old in with_extension(out, "whl")? {
        fs::remove_file(&old).map_err(at(&old))?;
    }
    cross_build::add_target(LINUX)?;
    plugin(tools)?;
    let mut maturin = tools.command("maturin");
    run(maturin
        .args(["build", "--quiet", "--locked", "--zig", "--target", LINUX])
        .args(["--compatibility", "manylinux2014"])
        .args(["--manifest-path", "bindings/python/Cargo.toml", "--out"])
        .arg(out))?;
    for path in with_extension(out, "whl")? {
        let bytes = fs::metadata(&path).map_err(at(&path))?.len();
        if bytes > MOST_BYTES {
            let most = MOST_BYTES;
            return Err(Error::TooLarge { path, bytes, most });
        }
    }
    Ok(())
}

/// Builds the plugin into the package.
fn plugin(tools: &Tools) -> Result<(), Error> {
    let core = format!("mujoco-core=={MUJOCO}");
    let mut pip = tools.command("pip");
    run(pip
        .args([
            "install",
            "--quiet",
            "--disable-pip-version-check",
            "--no-deps",
        ])
        .arg(core))?;
    let built = c_library::archive(tools)?;
    let package = cross_build::workspace().join("bindings/python/smart_actuator");
    let is_plugin = |path: &PathBuf| path.to_string_lossy().contains(PLUGIN);
    for old in with_extension(&package, "so")?
        .into_iter()
        .filter(is_plugin)
    {
        fs::remove_file(&old).map_err(at(&old))?;
    }
    let zig = format!("python -m ziglang cc -target x86_64-linux-gnu.{GLIBC} -lunwind");
    run(tools
        .on_path("bash")
        .args(["bindings/mujoco/build.sh", "python"])
        .arg(package.join(format!("{PLUGIN}{MUJOCO}.so")))
        .env("CC", zig)
        .env("ACTUATOR_C", built))
}

fn with_extension(folder: &Path, extension: &str) -> Result<Vec<PathBuf>, Error> {
    let entries = fs::read_dir(folder).map_err(at(folder))?;
    let paths = entries.map(|entry| Ok(entry.map_err(at(folder))?.path()));
    let paths = paths.collect::<Result<Vec<_>, Error>>()?;
    let has_it = |path: &PathBuf| path.extension().is_some_and(|e| e == extension);
    Ok(paths.into_iter().filter(has_it).collect())
}
