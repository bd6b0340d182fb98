//! The programs of the boards: as ELF with symbols for a debugger, and as the bytes of the flash.

use std::{fs, path::Path};

use cross_build::BOARD_TARGET;

use crate::{
    copy,
    error::{Error, at},
    tools::{Tools, target},
};

const PROGRAMS: [&str; 2] = ["actuator-board", "comm-board"];

/// Builds both programs, with their CRC.
pub fn make(_: &Tools, out: &Path) -> Result<(), Error> {
    // The folder that the tests of the boards use.
    let folder = target().join("board");
    for name in PROGRAMS {
        cross_build::build(BOARD_TARGET, &["build-board", "--bin", name], &folder)?;
        let elf = folder.join(BOARD_TARGET).join("board").join(name);
        program_image::stamp(&elf)?;
        let place = out.join("boards").join(name);
        copy(&elf, &place.with_extension("elf"))?;
        let image = place.with_extension("bin");
        fs::write(&image, program_image::flash(&elf)?).map_err(at(&image))?;
    }
    Ok(())
}
