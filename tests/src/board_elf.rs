//! The program of the board, built as it is flashed.

use std::{
    path::{Path, PathBuf},
    process::Command,
    sync::OnceLock,
};

/// Builds the board's release ELF, once in a process, and says where it is.
///
/// It has a target directory of its own, so that it waits for no other cargo.
///
/// # Panics
/// If it does not build; the compiler's words are in the test's output.
pub fn board_elf() -> &'static Path {
    static ELF: OnceLock<PathBuf> = OnceLock::new();
    ELF.get_or_init(|| build("actuator-board", &[]))
}

/// The same for the program with plain frames.
///
/// # Panics
/// As above.
pub fn plain_board_elf() -> &'static Path {
    static ELF: OnceLock<PathBuf> = OnceLock::new();
    ELF.get_or_init(|| build("actuator-board-plain", &[]))
}

/// The same for the program that runs nothing but the control law, built for speed, as what it is compared
/// with is.
///
/// # Panics
/// As above.
pub fn control_law_elf() -> &'static Path {
    static ELF: OnceLock<PathBuf> = OnceLock::new();
    ELF.get_or_init(|| {
        let fast = ["canopen", "firmware", "model-core"]
            .map(|package| format!("profile.board.package.{package}.opt-level=3"));
        build("control-law", &fast)
    })
}

/// The same for the program of the communication board.
///
/// # Panics
/// As above.
pub fn comm_board_elf() -> &'static Path {
    static ELF: OnceLock<PathBuf> = OnceLock::new();
    ELF.get_or_init(|| build("comm-board", &[]))
}

fn build(program: &str, settings: &[String]) -> PathBuf {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let workspace = (package.ancestors())
        .find(|folder| folder.join("Cargo.lock").is_file())
        .expect("a workspace has a lock file");
    let target = workspace.join("target").join("board");
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let status = Command::new(cargo)
        .current_dir(workspace)
        .args([
            "build-board",
            "--bin",
            program,
            "--locked",
            "--quiet",
            "--target-dir",
        ])
        .arg(&target)
        .args(settings.iter().flat_map(|setting| ["--config", setting]))
        // What the outer build was told about its own target does not hold for this one.
        .env_remove("RUSTFLAGS")
        .env_remove("CARGO_ENCODED_RUSTFLAGS")
        .status()
        .expect("cargo runs");
    assert!(status.success(), "the program of the board does not build");
    target.join("thumbv7em-none-eabihf/board").join(program)
}
