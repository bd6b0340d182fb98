//! `cargo run --release --bin study -- --out docs/study` writes the study.

use std::{path::PathBuf, process::ExitCode};

use clap::Parser;
use host_sim::file::WriteError;
use study::{Failure, claims, figures, page, runs, study::Study};

/// Repeats the paper's study on the emulated board, which takes some minutes on two cores.
#[derive(Debug, Parser)]
struct Arguments {
    /// Output folder of the study
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,
}

fn main() -> ExitCode {
    match Arguments::parse().run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::FAILURE
        }
    }
}

impl Arguments {
    fn run(&self) -> Result<(), Failure> {
        std::fs::create_dir_all(&self.out).map_err(|error| self.unwritable(error))?;
        let runs = runs::all(board_tests::program::firmware(), &runs::RunKey::all())?;
        let study = Study::of(runs)?;
        let claims = claims::all(&study)?;
        for (name, figure) in figures::all(&study)? {
            host_sim::plot::save(&figure, &self.out.join(name))?;
        }
        for (name, text) in page::files(&study, &claims) {
            host_sim::file::write(&self.out.join(name), text)?;
        }
        eprintln!(
            "{} runs, {} fits: {}",
            study.runs.len(),
            study.fits.len(),
            self.out.display()
        );
        Ok(())
    }

    fn unwritable(&self, source: std::io::Error) -> Failure {
        WriteError::new(&self.out, source).into()
    }
}
