//! Prints worst-case stack use and execution times of the actuator board's program, for all inputs,
//! or writes them into `docs/bounds.md`.

use std::path::Path;
use std::process::ExitCode;

use static_bounds::{Bounds, Error};

fn main() -> ExitCode {
    let arguments: Vec<_> = std::env::args().skip(1).collect();
    let writes = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => false,
        ["--write"] => true,
        _ => {
            eprintln!("usage: static-bounds [--write]");
            return ExitCode::from(2);
        }
    };
    match run(writes) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(writes: bool) -> Result<(), Error> {
    let document = Bounds::of_the_board()?.document();
    if !writes {
        print!("{document}");
        return Ok(());
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/bounds.md");
    std::fs::write(&path, document).map_err(|error| Error::File(path.display().to_string(), error))
}
