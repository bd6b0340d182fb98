//! Writes the CRC into the ELF file that is the last argument, then runs the command before it with
//! the file: `program-image probe-rs run --chip STM32F427ZITx ELF`.

#![forbid(unsafe_code)]

use std::ffi::OsString;
use std::path::Path;
use std::process::{Command, ExitCode};

use program_image::stamp;

const USAGE: &str = "usage: program-image [COMMAND [ARGUMENT]...] ELF";

fn main() -> ExitCode {
    let arguments: Vec<OsString> = std::env::args_os().skip(1).collect();
    let Some((elf, command)) = arguments.split_last().filter(|(elf, _)| *elf != "--help") else {
        eprintln!("{USAGE}");
        return ExitCode::from(2);
    };
    match stamp(Path::new(elf)) {
        Ok(Some(crc)) => eprintln!("CRC of the program: {crc:08x}"),
        Ok(None) => eprintln!("the program has no section for a CRC"),
        Err(error) => {
            eprintln!("error: {error}");
            return ExitCode::FAILURE;
        }
    }
    let Some((program, options)) = command.split_first() else {
        return ExitCode::SUCCESS;
    };
    match Command::new(program).args(options).arg(elf).status() {
        Ok(status) if status.success() => ExitCode::SUCCESS,
        Ok(_) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {}: {error}", program.display());
            ExitCode::FAILURE
        }
    }
}
