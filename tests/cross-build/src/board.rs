//! The programs of the boards, built as they are flashed.

use std::{
    path::{Path, PathBuf},
    sync::OnceLock,
};

use crate::{BOARD_TARGET, build, target_dir};

/// The ELF file of the actuator board, built once in a process.
///
/// # Panics
/// If it does not build.
pub fn board_elf() -> &'static Path {
    static ELF: OnceLock<PathBuf> = OnceLock::new();
    ELF.get_or_init(|| program("build-board", "actuator-board", &[]))
}

/// The ELF file of the actuator board with an STM32H743, built once in a process.
///
/// # Panics
/// If it does not build.
pub fn board_h743_elf() -> &'static Path {
    static ELF: OnceLock<PathBuf> = OnceLock::new();
    ELF.get_or_init(|| program("build-h743", "actuator-board-h743", &[]))
}

/// The ELF file of the communication board, built once in a process.
///
/// # Panics
/// If it does not build.
pub fn comm_board_elf() -> &'static Path {
    static ELF: OnceLock<PathBuf> = OnceLock::new();
    ELF.get_or_init(|| program("build-board", "comm-board", &[]))
}

/// The ELF file of the bring-up of the actuator board, built once in a process.
///
/// # Panics
/// If it does not build.
pub fn bring_up_elf() -> &'static Path {
    static ELF: OnceLock<PathBuf> = OnceLock::new();
    ELF.get_or_init(|| program("build-board", "bring-up", &[]))
}

/// The ELF file of the bootloader, which takes images of the development key; built once in a
/// process.
///
/// # Panics
/// If it does not build.
pub fn boot_elf() -> &'static Path {
    static ELF: OnceLock<PathBuf> = OnceLock::new();
    let settings = ["--features", "development-key"];
    ELF.get_or_init(|| program("build-boot", "actuator-boot", &settings))
}

/// The file of a program that this alias of `.cargo/config.toml` builds.
fn program(alias: &str, name: &str, settings: &[&str]) -> PathBuf {
    // A target folder of its own: the outer cargo holds the lock of the other.
    let folder = target_dir().join("board");
    let arguments = [&[alias, "--bin", name], settings].concat();
    if let Err(error) = build(BOARD_TARGET, &arguments, &folder) {
        panic!("{name}: {error}");
    }
    let elf = folder.join(BOARD_TARGET).join("board").join(name);
    if let Err(error) = program_image::stamp(&elf) {
        panic!("{error}");
    }
    elf
}
