//! `cargo run --release --bin package -- [--out FOLDER] [PART...]`: everything that a release has,
//! in the folder `dist`, with release notes, checksums, and a page that says
//! which file is for whom.
//!
//! Programs and libraries for Linux are linked by zig against glibc 2.17 (2014), so that they run
//! on older systems than the one that builds them. zig and maturin come from the package index of
//! Python into an environment of their own below `target`.

#![forbid(unsafe_code)]

mod boards;
mod c_library;
mod checksums;
mod components;
mod downloads;
mod error;
mod evidence;
mod pages;
mod program;
mod release_notes;
mod tools;
mod wheel;

use std::{
    fs,
    path::{Path, PathBuf},
    process::ExitCode,
    time::Instant,
};

use clap::{Parser, ValueEnum};
use error::{Error, at};
use tools::Tools;

/// Makes everything that a release has
#[derive(Debug, Parser)]
struct Options {
    /// The folder of the release [default: dist]
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// What is made; everything for this system unless given
    #[arg(value_name = "PART")]
    parts: Vec<Part>,
}

/// A part of the release. The pages are made by the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Part {
    /// Licences, changes, EDS and object dictionary
    Documents,
    /// The C library
    C,
    /// The Python package
    Wheel,
    /// The program `actuator`, and FMUs
    Program,
    /// The Python package for musl and for ARM
    Wheels,
    /// The program for any Linux on x86-64, without a library of the system
    Static,
    /// The program for any Linux on ARM
    Arm,
    /// The program for Windows
    Windows,
    /// The report, and the script for pages of others
    Pages,
    /// The programs of the boards
    Boards,
    /// The list of components (SBOM)
    Components,
}

impl Part {
    /// Whether it is for another system than that of the tests, and made on request only.
    fn is_for_another_system(self) -> bool {
        matches!(
            self,
            Self::Wheels | Self::Static | Self::Arm | Self::Windows
        )
    }

    fn make(self, tools: &Tools, out: &Path) -> Result<(), Error> {
        match self {
            Self::Documents => documents(out),
            Self::C => c_library::make(tools, out),
            Self::Wheel => wheel::make(tools, out),
            Self::Program => program::make(tools, out),
            Self::Wheels => wheel::make_others(tools, out),
            Self::Arm => program::make_arm(tools, out),
            Self::Static => program::make_static(tools, out),
            Self::Windows => program::make_windows(tools, out),
            Self::Pages => pages::make(tools, out),
            Self::Boards => boards::make(tools, out),
            Self::Components => components::make(tools, out),
        }
    }
}

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
    match run(Options::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(options: Options) -> Result<(), Error> {
    let out = options
        .out
        .unwrap_or_else(|| cross_build::workspace().join("dist"));
    let parts = if options.parts.is_empty() {
        let all = Part::value_variants().iter().copied();
        all.filter(|part| !part.is_for_another_system()).collect()
    } else {
        options.parts
    };
    fs::create_dir_all(&out).map_err(at(&out))?;
    let out = fs::canonicalize(&out).map_err(at(&out))?;
    let tools = Tools::ready()?;
    let begin = Instant::now();
    for (number, part) in (1..).zip(&parts) {
        let seconds = begin.elapsed().as_secs();
        println!(
            "-- {number} of {}, after {seconds} s: {part:?}",
            parts.len()
        );
        part.make(&tools, &out)?;
    }
    let changes = cross_build::workspace().join("CHANGELOG.md");
    let changes = fs::read_to_string(&changes).map_err(at(&changes))?;
    let boards = out.join("boards");
    let is_made = parts.contains(&Part::Boards);
    let stale = evidence::stale();
    if stale.is_some() {
        println!("unverified: the release notes list the stale experiments");
    }
    release_notes::write(&changes, is_made.then_some(&boards), stale.as_deref(), &out)?;
    downloads::write(&out)?;
    checksums::write(&out)?;
    println!("{}", out.display());
    Ok(())
}

fn documents(out: &Path) -> Result<(), Error> {
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
