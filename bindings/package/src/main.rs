//! `cargo run --release --bin package -- [--out FOLDER] [PART...]`: everything that a release has,
//! in the folder `dist`, with checksums.
//!
//! Programs and libraries for Linux are linked by zig against glibc 2.17 (2014), so that they run on
//! older systems than the one that builds them. zig and maturin come from the package index of
//! Python into an environment of their own below `target`.

#![forbid(unsafe_code)]

mod boards;
mod c_library;
mod checksums;
mod error;
mod pages;
mod program;
mod tools;
mod wheel;

use std::{
    env, fs,
    path::{Path, PathBuf},
    process::ExitCode,
};

use error::{Error, at};
use tools::Tools;

const USAGE: &str = "usage: package [--out FOLDER] [PART]...
Parts: wheel, program (with FMUs), c, boards, pages (needs program), documents; all by default.";

/// A part of the release.
type Part = fn(&Tools, &Path) -> Result<(), Error>;

/// All parts in the order in which they are made.
const PARTS: [(&str, Part); 6] = [
    ("documents", documents),
    ("c", c_library::make),
    ("wheel", wheel::make),
    ("program", program::make),
    ("pages", pages::make),
    ("boards", boards::make),
];

/// Files of the repository that are part of the release, with their places in it.
const DOCUMENTS: [(&str, &str); 6] = [
    ("CHANGELOG.md", "CHANGELOG.md"),
    ("CITATION.cff", "CITATION.cff"),
    ("LICENSE-APACHE", "LICENSE-APACHE"),
    ("LICENSE-MIT", "LICENSE-MIT"),
    ("docs/smart-actuator.eds", "smart-actuator.eds"),
    ("docs/object-dictionary.md", "object-dictionary.md"),
];

fn main() -> ExitCode {
    match run(env::args().skip(1)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(mut arguments: impl Iterator<Item = String>) -> Result<(), Error> {
    let mut out = cross_build::workspace().join("dist");
    let mut chosen = Vec::new();
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--out" => out = PathBuf::from(arguments.next().ok_or(Error::Usage(USAGE))?),
            name => {
                let part = PARTS.iter().find(|(part, _)| *part == name);
                chosen.push(*part.ok_or(Error::Usage(USAGE))?);
            }
        }
    }
    if chosen.is_empty() {
        chosen = PARTS.to_vec();
    }
    fs::create_dir_all(&out).map_err(at(&out))?;
    let out = fs::canonicalize(&out).map_err(at(&out))?;
    let tools = Tools::ready()?;
    for (name, make) in chosen {
        println!("-- {name}");
        make(&tools, &out)?;
    }
    checksums::write(&out)?;
    println!("{}", out.display());
    Ok(())
}

fn documents(_: &Tools, out: &Path) -> Result<(), Error> {
    for (from, to) in DOCUMENTS {
        copy(&cross_build::workspace().join(from), &out.join(to))?;
    }
    Ok(())
}

/// Copies a file into a folder that may not exist yet.
fn copy(from: &Path, to: &Path) -> Result<(), Error> {
    let folder = to.parent().unwrap_or(to);
    fs::create_dir_all(folder).map_err(at(folder))?;
    fs::copy(from, to).map(drop).map_err(at(from))
}
