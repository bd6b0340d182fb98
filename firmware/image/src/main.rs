//! Writes the CRC into the ELF file that is the last argument, then runs the command before it with
//! the file: `program-image probe-rs run --chip STM32F427ZITx ELF`.
//!
//! A program that is linked for the slot is not run alone: the bootloader is built and flashed, and
//! the program as a signed image ([`program_image::flashing`]).

#![forbid(unsafe_code)]

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use program_image::{
    flashing::{KEY, PUBLIC_KEY, boot_build, commands, is_in_slot, write_image},
    stamp,
};

const USAGE: &str = "usage: program-image [COMMAND [ARGUMENT]...] ELF";

fn main() -> ExitCode {
    let arguments: Vec<OsString> = std::env::args_os().skip(1).collect();
    let Some((elf, command)) = arguments.split_last().filter(|(elf, _)| *elf != "--help") else {
        eprintln!("{USAGE}");
        return ExitCode::from(2);
    };
    match prepare(Path::new(elf), command).and_then(|lines| lines.iter().try_for_each(|l| run(l))) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Writes the CRC; returns the command lines to be run.
fn prepare(elf: &Path, command: &[OsString]) -> Result<Vec<Vec<OsString>>, String> {
    match stamp(elf).map_err(|error| error.to_string())? {
        Some(crc) => eprintln!("CRC of the program: {crc:08x}"),
        None => eprintln!("the program has no section for a CRC"),
    }
    if command.is_empty() {
        return Ok(Vec::new());
    }
    if !is_in_slot(elf).map_err(|error| error.to_string())? {
        let mut line = command.to_vec();
        line.push(elf.into());
        return Ok(vec![line]);
    }
    let key = std::env::var_os(KEY).map(PathBuf::from);
    if key.is_none() {
        eprintln!("signed with the development key, which is public; {KEY} names another");
    }
    build_boot(key.as_deref())?;
    let image = write_image(elf, key.as_deref()).map_err(|error| error.to_string())?;
    Ok(commands(command, elf, &image))
}

/// Builds the bootloader beside the program.
fn build_boot(key: Option<&Path>) -> Result<(), String> {
    let (arguments, public) = boot_build(key);
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command.args(arguments).args(["--quiet", "--locked"]);
    if let Some(public) = public {
        let public = std::path::absolute(&public).map_err(|error| error.to_string())?;
        command.env(PUBLIC_KEY, public);
    }
    check(&mut command)
}

fn run(line: &[OsString]) -> Result<(), String> {
    let Some((program, arguments)) = line.split_first() else {
        return Ok(());
    };
    check(Command::new(program).args(arguments))
}

fn check(command: &mut Command) -> Result<(), String> {
    let name = command.get_program().display().to_string();
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("{name}: {status}")),
        Err(error) => Err(format!("{name}: {error}")),
    }
}
