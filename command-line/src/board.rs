//! `actuator board`: the board's program on the emulated board.

mod console;
mod link;
mod show;

use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use canopen::cob_id;
use clap::{Args, ValueEnum};
use virtual_board::can::{Frame, Id};
use virtual_board::faults::{Planned, parse_plan};
use virtual_board::plant::BoardPlantOptions;
use virtual_board::run::{Attachments, Flow, Options, RunSide, Script, View, client, run_with};

use self::show::RowPrinter;
use crate::bounded;
use crate::emulated;
use crate::error::Error;

/// Runs the board's program on the emulated board, with the motor and its gear train.
///
/// Lines of standard input are requests to the board over its CAN bus, by CANopen. `enable` and
/// `disable` switch the drive's power; an angle in degrees moves the enabled drive there in profile
/// position mode; `stop` is a quick stop, `ack` resets faults, `save` saves the parameters;
/// `capture start` and `capture stop` begin and end the board's capture, and `capture save FILE`
/// writes it for `identify`; `servo 1500` sends servo pulses of 1500 us, `servo off` ends them;
/// `end` ends the run.
#[derive(Debug, Args)]
pub struct Board {
    /// ELF file of the board's program (`cargo build-board`: actuator-board)
    #[arg(long, value_name = "FILE")]
    elf: PathBuf,
    /// Faults and their times (TOML)
    #[arg(long, value_name = "FILE")]
    faults: Option<PathBuf>,
    /// Port of this machine for GDB; the run begins when GDB continues it
    #[arg(long, value_name = "PORT")]
    gdb: Option<u16>,
    /// How fast the virtual time passes
    #[arg(long, value_enum, default_value_t = Pace::Real)]
    pace: Pace,
    /// What is printed
    #[arg(long, value_enum, default_value_t = Format::Plot)]
    format: Format,
    /// End of the run, s of virtual time
    #[arg(long = "for", value_name = "SECONDS", default_value_t = 3600.0)]
    seconds: f64,
    /// Noise, spread of friction and a crooked magnet are drawn from this seed
    #[arg(long, value_name = "NUMBER", default_value_t = 0)]
    seed: u64,
    /// Rate of the CAN port, bit/s
    #[arg(long, value_name = "RATE", default_value_t = 1_000_000, value_parser = clap::value_parser!(u32).range(10_000..=1_000_000))]
    bit_rate: u32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Pace {
    /// In real time
    Real,
    /// As fast as possible
    Max,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Format {
    /// A line twenty times a second of virtual time, with the angle on an axis
    Plot,
    /// Every PWM period, comma separated
    Csv,
    /// Nothing but the end
    None,
}

/// Longest run, s: a week.
const LONGEST_S: f64 = 7.0 * 86_400.0;

impl Board {
    /// Runs.
    ///
    /// # Errors
    /// A file that cannot be read, a port that is taken, or a time outside its range.
    pub fn run(self) -> Result<(), Error> {
        if !(0.001..=LONGEST_S).contains(&self.seconds) {
            let message = format!("--for is {}, expected 0.001 to {LONGEST_S} s", self.seconds);
            return Err(refusal(&message));
        }
        let faults = self.faults.as_deref().map(plan).transpose()?;
        let firmware = emulated::firmware(&self.elf)?;
        let chip = firmware.actuator_chip().map_err(|error| refusal(&error))?;
        let options = Options {
            chip,
            plant: BoardPlantOptions::realistic(self.seed),
            ports_bit_s: vec![self.bit_rate],
            faults: faults.unwrap_or_default(),
            keeps_trace: false,
            ..Options::for_ms((self.seconds * 1e3) as u64)
        };
        let debugger = self.listen()?;
        let attachments = Attachments {
            debugger,
            ..Attachments::default()
        };
        let script = Session::new(&self);
        let started = Instant::now();
        let finished =
            run_with(&firmware, options, script, attachments).map_err(|error| refusal(&error))?;
        let seconds = finished.end_ns as f64 * 1e-9;
        let wall_s = started.elapsed().as_secs_f64();
        note!(
            "{seconds} s in {wall_s:.2} s: {:.1} times real time; {} instructions",
            seconds / wall_s,
            finished.instructions
        );
        note!("trace {}", finished.trace.hash());
        for reset in &finished.resets {
            note!("reset at {} ms: {:?}", reset.at.0 / 1_000_000, reset.cause);
        }
        if !finished.gaps.is_empty() {
            note!("not emulated:\n{}", finished.gaps);
        }
        Ok(())
    }

    fn listen(&self) -> Result<Option<TcpListener>, Error> {
        let Some(port) = self.gdb else {
            return Ok(None);
        };
        let listener = TcpListener::bind(("127.0.0.1", port))
            .map_err(|error| refusal(&format!("--gdb {port}: {error}")))?;
        if let Ok(address) = listener.local_addr() {
            note!("GDB: target remote {address}");
        }
        Ok(Some(listener))
    }
}

/// The most bytes of a fault plan: those of ten thousand faults.
const MOST_PLAN: u64 = 1 << 20;

/// The plan of faults in a file.
pub(crate) fn plan(path: &Path) -> Result<Vec<Planned>, Error> {
    let text = String::from_utf8(bounded::read(path, MOST_PLAN)?)
        .map_err(|error| refusal(&format!("{}: {error}, expected a text", path.display())))?;
    parse_plan(path, &text).map_err(|error| refusal(&error))
}

fn refusal(what: &dyn std::fmt::Display) -> Error {
    Error::Board(what.to_string())
}

/// The commanded angle of the console, deg.
type Target = Arc<Mutex<Option<f64>>>;

/// The environment of the board: its bus, the console and the output.
struct Session {
    run_side: RunSide,
    /// The commanded angle to be shown, deg.
    target_deg: Target,
    printer: RowPrinter,
    started: Option<Instant>,
}

impl Session {
    fn new(arguments: &Board) -> Self {
        let (typed, lines) = channel();
        let (client_side, run_side) = client();
        let target_deg = Target::default();
        let shown = Arc::clone(&target_deg);
        // Both threads end with the program: a read of standard input cannot be interrupted.
        std::thread::spawn(move || console::read(&typed));
        std::thread::spawn(move || console::run(&lines, client_side, shown));
        Self {
            run_side,
            target_deg,
            printer: RowPrinter::new(arguments.format),
            started: (arguments.pace == Pace::Real).then(Instant::now),
        }
    }

    fn keep_pace(&self, now_ns: u64) {
        if let Some(started) = self.started {
            let due = started + Duration::from_nanos(now_ns);
            std::thread::sleep(due.saturating_duration_since(Instant::now()));
        }
    }
}

/// Boot-up of the node, and the NMT command that starts it.
const BOOT_UP: Id = Id::Standard(cob_id::HEARTBEAT as u16 + 1);
const START: [u8; 2] = [1, 1];

impl Script for Session {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        let now_ns = view.now_ns();
        let Some(port) = view.port(0) else {
            return Flow::End;
        };
        let sent = port.take_received();
        // After each reset the node waits for the NMT start.
        if sent
            .iter()
            .any(|(_, frame)| frame.id == BOOT_UP && frame.payload() == [0])
        {
            port.send(now_ns, Frame::data_frame(Id::Standard(0), &START));
        }
        let frames = sent.iter().map(|(_, frame)| *frame);
        if self.run_side.exchange(view, frames) == Flow::End {
            return Flow::End;
        }
        let target_deg = self.target_deg.lock().map_or(None, |target| *target);
        let is_open = self.printer.row(view.row, target_deg, &sent);
        self.keep_pace(now_ns);
        if is_open { Flow::Continue } else { Flow::End }
    }
}
