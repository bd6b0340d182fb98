//! Builds the workspace's programs for targets other than the PC.
//!
//! Tests run the same ELF that is flashed, and the browser page contains a WebAssembly module. Both
//! are built by a cargo of their own, for a target that a new machine does not have yet:
//! [`build`] adds it with `rustup target add` where it is missing.

mod board;
mod target;

use std::{
    io,
    path::{Path, PathBuf},
    process::{Command, ExitStatus},
};

pub use board::{board_elf, board_h743_elf, boot_elf, bring_up_elf, comm_board_elf};
pub use target::add_target;

/// The target of the boards.
pub const BOARD_TARGET: &str = "thumbv7em-none-eabihf";

/// The target of the browser page.
pub const WEB_TARGET: &str = "wasm32-unknown-unknown";

/// Why a program was not built.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A tool did not start.
    #[error("cannot run `{command}`: {source}")]
    Start {
        /// The command line.
        command: String,
        /// The operating system's reason.
        source: io::Error,
    },
    /// The target is missing and cannot be added.
    #[error(
        "the Rust target {target} is not installed, and `rustup target add {target}` failed:\n{reason}\n\
         Install the target for the toolchain of rust-toolchain.toml, then repeat the command."
    )]
    Target {
        /// The target triple.
        target: String,
        /// What rustup printed.
        reason: String,
    },
    /// The compiler failed; its messages are on standard error.
    #[error("`{command}` failed: {status}")]
    Build {
        /// The command line.
        command: String,
        /// The exit status.
        status: ExitStatus,
    },
    /// The lock file of the target folder cannot be used.
    #[error("{}: {source}", path.display())]
    Lock {
        /// The lock file.
        path: PathBuf,
        /// The operating system's reason.
        source: io::Error,
    },
}

/// The workspace's folder.
pub fn workspace() -> &'static Path {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    package.ancestors().nth(2).unwrap_or(package)
}

/// The folder of what is built: that of the environment variable `CARGO_TARGET_DIR`, or `target`.
pub(crate) fn target_dir() -> PathBuf {
    let folder = std::env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into());
    workspace().join(folder)
}

/// Runs `cargo ARGUMENTS --target-dir FOLDER` for a target, which it adds where it is missing.
///
/// # Errors
/// If the target cannot be added, or cargo fails.
///
/// ```no_run
/// let folder = cross_build::workspace().join("target/board");
/// cross_build::build(cross_build::BOARD_TARGET, &["build-board"], &folder)?;
/// # Ok::<(), cross_build::Error>(())
/// ```
pub fn build(target: &str, arguments: &[&str], target_dir: &Path) -> Result<(), Error> {
    add_target(target)?;
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command
        .current_dir(workspace())
        .args(arguments)
        .args(["--locked", "--quiet", "--target-dir"])
        .arg(target_dir)
        // The flags of the outer build are for the PC.
        .env_remove("RUSTFLAGS")
        .env_remove("CARGO_ENCODED_RUSTFLAGS");
    let status = command.status().map_err(|source| Error::Start {
        command: format!("{command:?}"),
        source,
    })?;
    if !status.success() {
        return Err(Error::Build {
            command: format!("{command:?}"),
            status,
        });
    }
    Ok(())
}
