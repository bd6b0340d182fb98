//! The programs of the boards: as ELF with symbols for a debugger, as the bytes of the flash, and
//! as a signed image.
//!
//! Image and bootloader are those of the key that the environment variable `ACTUATOR_KEY` names,
//! whose public key `ACTUATOR_PUBLIC_KEY` names; without them, those of the development key.

use std::{
    env, fs,
    path::{Path, PathBuf},
};

use cross_build::BOARD_TARGET;
use program_image::flashing::{KEY, boot_build, boot_elf, is_in_slot, write_image};

use crate::{
    copy,
    error::{Error, at},
    tools::{Tools, target},
};

/// The programs, each with the alias of cargo that builds it.
const PROGRAMS: [(&str, &str); 3] = [
    ("build-board", "actuator-board"),
    ("build-h743", "actuator-board-h743"),
    ("build-board", "comm-board"),
];

/// Builds the programs, with their CRC, and the bootloader.
pub fn make(_: &Tools, out: &Path) -> Result<(), Error> {
    // The folder that the tests of the boards use.
    let folder = target().join("board");
    let key = env::var_os(KEY).map(PathBuf::from);
    for (alias, name) in PROGRAMS {
        cross_build::build(BOARD_TARGET, &[alias, "--bin", name], &folder)?;
        let elf = folder.join(BOARD_TARGET).join("board").join(name);
        program_image::stamp(&elf)?;
        let place = out.join("boards").join(name);
        copy(&elf, &place.with_extension("elf"))?;
        write_flash(&elf, &place.with_extension("bin"))?;
        if is_in_slot(&elf)? {
            let image = write_image(&elf, key.as_deref())?;
            copy(&image, &place.with_extension("img"))?;
            let (arguments, _) = boot_build(key.as_deref());
            cross_build::build(BOARD_TARGET, &arguments, &folder)?;
            copy(&boot_elf(&elf), &out.join("boards/actuator-boot.elf"))?;
            write_flash(&boot_elf(&elf), &out.join("boards/actuator-boot.bin"))?;
        }
    }
    Ok(())
}

/// Writes what an ELF file has in the flash.
fn write_flash(elf: &Path, to: &Path) -> Result<(), Error> {
    fs::write(to, program_image::flash(elf)?).map_err(at(to))
}
