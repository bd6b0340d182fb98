//! The tools from Python's package index, and the builds that use them.

use std::{
    env,
    ffi::OsString,
    io::{self, IsTerminal as _},
    path::{Path, PathBuf},
    process::{Command, ExitStatus, Stdio},
};

use crate::error::Error;

/// The tools with their versions: the linker for an old glibc and for Windows, and the maker of
/// wheels.
const TOOLS: [&str; 3] = [
    "ziglang==0.17.1",
    "cargo-zigbuild==0.24.0",
    "maturin==1.16.0",
];

/// The target of Linux, as rustup names it.
pub const LINUX: &str = "x86_64-unknown-linux-gnu";

/// The oldest glibc that what is built runs with: that of Rust's standard library.
pub const GLIBC: &str = "2.17";

/// The target of Linux on ARM.
pub const LINUX_ARM: &str = "aarch64-unknown-linux-gnu";

/// The target of Windows.
pub const WINDOWS: &str = "x86_64-pc-windows-gnu";

/// The targets of Linux with musl: their programs need no library of the system.
pub const MUSL: &str = "x86_64-unknown-linux-musl";
/// That on ARM.
pub const MUSL_ARM: &str = "aarch64-unknown-linux-musl";

/// An environment of Python with the tools.
pub struct Tools {
    programs: PathBuf,
    /// `PATH` with the tools first.
    path: OsString,
}

impl Tools {
    /// Installs the tools below `target` where they are missing.
    pub fn ready() -> Result<Self, Error> {
        let folder = target().join("package/tools");
        let programs = folder.join("bin");
        if !programs.join("maturin").is_file() || !programs.join("cargo-zigbuild").is_file() {
            run(Command::new("python3").args(["-m", "venv"]).arg(&folder))?;
            let mut pip = Command::new(programs.join("pip"));
            run(pip
                .args(["install", "--quiet", "--disable-pip-version-check"])
                .args(TOOLS))?;
        }
        let mut path = vec![programs.clone()];
        path.extend(env::split_paths(&env::var_os("PATH").unwrap_or_default()));
        Ok(Self {
            programs,
            path: env::join_paths(path).unwrap_or_default(),
        })
    }

    /// A tool, in the workspace's folder.
    pub fn command(&self, name: &str) -> Command {
        self.with_tools(Command::new(self.programs.join(name)))
    }

    /// A program of the system that calls the tools, in the workspace's folder.
    pub fn on_path(&self, name: &str) -> Command {
        self.with_tools(Command::new(name))
    }

    fn with_tools(&self, mut command: Command) -> Command {
        command
            .current_dir(cross_build::workspace())
            .env("PATH", &self.path)
            .env("CARGO_TARGET_DIR", target());
        command
    }

    /// `cargo rustc --release` of a library or program, linked by zig; `flags` are those of the
    /// linker. The folder with the result.
    pub fn build(
        &self,
        triple: &str,
        arguments: &[&str],
        flags: &[&str],
        variables: &[(&str, &Path)],
    ) -> Result<PathBuf, Error> {
        println!("   for {triple}: {}", arguments.join(" "));
        cross_build::add_target(triple)?;
        let linked = match triple {
            LINUX | LINUX_ARM => format!("{triple}.{GLIBC}"),
            other => other.to_owned(),
        };
        let mut command = self.command("cargo-zigbuild");
        command
            .args(["rustc", "--locked", "--release", "--target"])
            .arg(linked)
            .args(quiet())
            .args(arguments)
            .envs(variables.iter().copied())
            .arg("--");
        for flag in flags {
            command.arg(format!("-Clink-arg={flag}"));
        }
        run(&mut command)?;
        Ok(target().join(triple).join("release"))
    }
}

/// The compilers show their progress on a terminal only.
pub fn quiet() -> Option<&'static str> {
    (!io::stderr().is_terminal()).then_some("--quiet")
}

/// The folder of what is built.
pub fn target() -> PathBuf {
    let folder = env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into());
    cross_build::workspace().join(folder)
}

/// Runs a command to its end.
pub fn run(command: &mut Command) -> Result<(), Error> {
    let status = command.status();
    succeeded(command, status)
}

/// Runs a command to its end; returns what it prints.
pub fn output(command: &mut Command) -> Result<Vec<u8>, Error> {
    let output = command.stderr(Stdio::inherit()).output();
    let (status, printed) = match output {
        Ok(output) => (Ok(output.status), output.stdout),
        Err(source) => (Err(source), Vec::new()),
    };
    succeeded(command, status).map(|()| printed)
}

fn succeeded(command: &Command, status: io::Result<ExitStatus>) -> Result<(), Error> {
    let command = format!("{command:?}");
    match status {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(Error::Failed { command, status }),
        Err(source) => Err(Error::Start { command, source }),
    }
}
