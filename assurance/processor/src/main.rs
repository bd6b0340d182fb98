//! Runs the board's program on the emulated board and on a second emulator, in step, and writes
//! what was compared into `results.md`.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::{Arc, Mutex};
use std::time::Instant;

use board_tests::frames::Frame;
use board_tests::master::Master;
use board_tests::program::firmware;
use board_tests::workloads::{TICKS, everything};
use clap::Parser;
use processor_comparison::document;
use processor_comparison::shadow::{Defect, Shadow};
use virtual_board::plant::BoardPlantOptions;
use virtual_board::run::{Attachments, Flow, Options, Script, View, run_with};

/// Compares the emulated board's processor with a second emulator.
#[derive(Debug, Parser)]
struct Arguments {
    /// The library `libunicorn.so.2`.
    #[arg(long)]
    library: PathBuf,
    /// Virtual time of the run, s.
    #[arg(long, default_value_t = 20)]
    seconds: u64,
    /// Makes the second emulator fail after a million instructions; the run succeeds if it is
    /// found.
    #[arg(long)]
    defect: Option<Defect>,
    /// Writes the result into results.md.
    #[arg(long)]
    write: bool,
}

/// Instructions before a defect: the board has started and moves.
const BEFORE_DEFECT: u64 = 1_000_000;

/// The master, and reports of the progress.
struct Progress<F> {
    master: Master<F>,
    started: Instant,
    reported_s: u64,
    seconds: u64,
}

impl<F: Fn(u64) -> Vec<Frame> + Send> Script for Progress<F> {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        let now_s = view.now_ns() / 1_000_000_000;
        if now_s >= self.reported_s + 10 {
            self.reported_s = now_s;
            let elapsed = self.started.elapsed().as_secs();
            eprintln!("{now_s} of {} s compared after {elapsed} s", self.seconds);
        }
        self.master.at_edge(view)
    }
}

fn main() -> ExitCode {
    match compare(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn compare(arguments: &Arguments) -> Result<(), String> {
    let vectors = firmware().section(".vector_table").start as u32;
    let mut shadow =
        Shadow::open(&arguments.library, vectors).map_err(|error| error.to_string())?;
    shadow.defect = arguments.defect.map(|defect| (defect, BEFORE_DEFECT));
    let interrupt = Arc::clone(&shadow.stop);
    let elf = std::fs::read(cross_build::board_elf()).map_err(|error| error.to_string())?;
    let handlers = program_handlers::handlers(&elf).map_err(|error| error.to_string())?;
    let shadow = Arc::new(Mutex::new(shadow));
    let attachments = Attachments {
        observer: Some(shadow.clone()),
        interrupt: Some(interrupt),
        ..Attachments::default()
    };
    let options = Options {
        plant: BoardPlantOptions::realistic(3),
        keeps_trace: false,
        ..Options::for_ms(1000 * arguments.seconds)
    };
    let script = Progress {
        master: Master::new(|tick| everything(tick % TICKS)),
        started: Instant::now(),
        reported_s: 0,
        seconds: arguments.seconds,
    };
    let finished = run_with(firmware(), options, script, attachments);
    let finished = finished.map_err(|error| error.to_string())?;
    let shadow = shadow.lock().map_err(|error| error.to_string())?;
    let found = shadow.difference.as_ref().map(|difference| {
        let after = shadow.compared.instructions;
        format!("after {after} instructions: {difference}")
    });
    match (found, arguments.defect) {
        (None, None) => {}
        (Some(found), Some(defect)) => {
            println!("the planted defect {defect:?} is found: {found}");
            return Ok(());
        }
        (Some(found), None) => return Err(found),
        (None, Some(defect)) => return Err(format!("the planted defect {defect:?} is not found")),
    }
    let text = document::comparison(&shadow, &handlers, finished.end_ns);
    println!("{text}");
    if arguments.write {
        document::write(&text).map_err(|error| error.to_string())?;
    }
    Ok(())
}
