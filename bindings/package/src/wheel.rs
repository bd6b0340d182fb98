//! The wheels of the Python package, each for all versions of Python from 3.9, with the plugin of
//! MuJoCo where MuJoCo has a wheel.

use std::{
    fs,
    path::{Path, PathBuf},
};

use crate::{
    c_library,
    error::{Error, at},
    tools::{GLIBC, LINUX, LINUX_ARM, MUSL, MUSL_ARM, Tools, run, target},
};

/// The greatest size of a wheel, bytes.
const MOST_BYTES: u64 = 4_000_000;

/// The version of MuJoCo that the plugin is linked with.
const MUJOCO: &str = "4.0.0";

/// The name of the plugin before the version.
const PLUGIN: &str = "libsmart_actuator-mujoco-";

/// A system with a wheel.
struct System {
    target: &'static str,
    /// What it is built for, as wheels name it.
    compatibility: &'static str,
    /// That of the wheel of MuJoCo.
    mujoco: Option<&'static str>,
}

/// Linux with glibc on x86-64.
const USUAL: System = System {
    target: LINUX,
    compatibility: "manylinux2014",
    mujoco: Some("manylinux_2_28_x86_64"),
};

const OTHERS: [System; 3] = [
    System {
        target: LINUX_ARM,
        compatibility: "manylinux2014",
        mujoco: Some("manylinux_2_28_aarch64"),
    },
    System {
        target: MUSL,
        compatibility: "musllinux_1_2",
        mujoco: None,
    },
    System {
        target: MUSL_ARM,
        compatibility: "musllinux_1_2",
        mujoco: None,
    },
];

/// Makes the wheel of most computers in place of an older one.
pub fn make(tools: &Tools, out: &Path) -> Result<(), Error> {
    remove(&with_extension(out, "whl")?)?;
    wheel(tools, &USUAL, out)?;
    // For MuJoCo without Python.
    let plugin = built_plugin();
    let folder = out.join("mujoco");
    fs::create_dir_all(&folder).map_err(at(&folder))?;
    remove(&with_extension(&folder, "so")?)?;
    let copy = folder.join(plugin.file_name().unwrap_or_default());
    fs::copy(&plugin, &copy).map_err(at(&copy))?;
    Ok(())
}

/// The folder of the Python package, which contains the plugin.
fn package() -> PathBuf {
    cross_build::workspace().join("bindings/python/smart_actuator")
}

/// The plugin of the system that was built last.
fn built_plugin() -> PathBuf {
    package().join(format!("{PLUGIN}{MUJOCO}.so"))
}

/// Makes those of other systems in a folder of their own: pip takes one folder of wheels for one
/// system.
pub fn make_others(tools: &Tools, out: &Path) -> Result<(), Error> {
    let folder = out.join("wheels");
    fs::create_dir_all(&folder).map_err(at(&folder))?;
    remove(&with_extension(&folder, "whl")?)?;
    let mut others = OTHERS.iter();
    others.try_for_each(|system| wheel(tools, system, &folder))
}

fn wheel(tools: &Tools, system: &System, out: &Path) -> Result<(), Error> {
    println!("   for {}: the wheel", system.target);
    cross_build::add_target(system.target)?;
    plugin(tools, system)?;
    let mut maturin = tools.command("maturin");
    run(maturin
        .args(["build", "--quiet", "--locked", "--zig", "--target"])
        .args([system.target, "--compatibility", system.compatibility])
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

/// Builds the plugin into the package, in place of that of another system.
fn plugin(tools: &Tools, system: &System) -> Result<(), Error> {
    let mut old = with_extension(&package(), "so")?;
    old.retain(|path| path.to_string_lossy().contains(PLUGIN));
    remove(&old)?;
    let Some(platform) = system.mujoco else {
        return Ok(());
    };
    let mujoco = target().join("package").join(platform);
    let mut pip = tools.command("pip");
    run(pip
        .args(["install", "--quiet", "--disable-pip-version-check"])
        .args(["--upgrade", "--no-deps", "--only-binary=:all:"])
        .args(["--platform", platform, "--target"])
        .arg(&mujoco)
        .arg(format!("mujoco-core=={MUJOCO}")))?;
    let built = c_library::archive(tools, system.target)?;
    let zig = system.target.replace("-unknown", "");
    run(tools
        .on_path("bash")
        .args(["bindings/mujoco/build.sh", "python"])
        .arg(built_plugin())
        .env("PYTHONPATH", mujoco)
        .env(
            "CC",
            format!("python -m ziglang cc -target {zig}.{GLIBC} -lunwind"),
        )
        .env("ACTUATOR_C", built))
}

fn remove(files: &[PathBuf]) -> Result<(), Error> {
    let mut files = files.iter();
    files.try_for_each(|file| fs::remove_file(file).map_err(at(file)))
}

fn with_extension(folder: &Path, extension: &str) -> Result<Vec<PathBuf>, Error> {
    let entries = fs::read_dir(folder).map_err(at(folder))?;
    let paths = entries.map(|entry| Ok(entry.map_err(at(folder))?.path()));
    let paths = paths.collect::<Result<Vec<_>, Error>>()?;
    let has_it = |path: &PathBuf| path.extension().is_some_and(|e| e == extension);
    Ok(paths.into_iter().filter(has_it).collect())
}
