//! `actuator board`: the board's program on the emulated board.

mod console;
mod save;
mod show;

use std::net::TcpListener;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use clap::{Args, ValueEnum};
use virtual_board::faults::read_plan;
use virtual_board::plant::BoardPlantOptions;
use virtual_board::run::{Company, Firmware, Flow, Options, Script, View, run_with};

use self::console::Command;
use self::save::{Saved, Saving};
use self::show::Show;
use crate::error::Error;

/// Runs the board's program on the emulated board, around the bench.
///
/// What is typed goes to the board by its CAN bus: an angle in degrees commands it, and `enable`,
/// `disable`, `stop`, `ack`, `save` are orders, and enabled it goes to 0 deg until an angle is typed; `capture start` and `capture stop` begin and end the
/// board's capture, `capture save FILE` writes it for `identify`; `servo 1500` sends servo pulses,
/// `servo off` ends them; `end` ends the run. The angle is commanded twenty times a second.
#[derive(Debug, Args)]
pub struct Board {
    /// ELF file of the board's program with plain frames (`cargo build-board`: actuator-board-plain)
    #[arg(long, value_name = "FILE")]
    elf: PathBuf,
    /// What breaks and when (TOML)
    #[arg(long, value_name = "FILE")]
    faults: Option<PathBuf>,
    /// Serves GDB at this port of this machine, and waits for it
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
    /// Noise, spread of friction and a crooked magnet, by this seed; ideal without it
    #[arg(long, value_name = "NUMBER")]
    seed: Option<u64>,
    /// Rate of the CAN port, bit/s
    #[arg(long, value_name = "RATE", default_value_t = 1_000_000, value_parser = clap::value_parser!(u32).range(10_000..=1_000_000))]
    bit_rate: u32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Pace {
    /// As on the wall
    Real,
    /// As fast as it goes
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

/// A function that only the program with a CANopen node has.
const NODE: &str = "communicate";

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
        let firmware = Firmware::read(&self.elf).map_err(|error| refusal(&error))?;
        if firmware.address(NODE).is_ok() {
            let message = format!(
                "{}: this program speaks CANopen, expected one with plain frames as actuator-board-plain; `actuator serve --elf` runs it",
                self.elf.display()
            );
            return Err(refusal(&message));
        }
        let faults = match &self.faults {
            Some(path) => read_plan(path).map_err(|error| refusal(&error))?,
            None => Vec::new(),
        };
        let options = Options {
            rig: self
                .seed
                .map_or_else(BoardPlantOptions::default, BoardPlantOptions::realistic),
            ports_bit_s: vec![self.bit_rate],
            faults,
            keeps_trace: false,
            ..Options::for_ms((self.seconds * 1e3) as u64)
        };
        let debugger = self.listen()?;
        let company = Company {
            debugger,
            ..Company::default()
        };
        let script = Session::new(&self);
        let started = Instant::now();
        let finished =
            run_with(&firmware, options, script, company).map_err(|error| refusal(&error))?;
        let seconds = finished.end_ns as f64 * 1e-9;
        let wall_s = started.elapsed().as_secs_f64();
        eprintln!(
            "{seconds} s in {wall_s:.2} s: {:.1} times real time; {} instructions",
            seconds / wall_s,
            finished.instructions
        );
        eprintln!("trace {}", finished.trace.hash());
        for reset in &finished.resets {
            eprintln!("reset at {} ms: {:?}", reset.at.0 / 1_000_000, reset.cause);
        }
        if !finished.gaps.is_empty() {
            eprintln!("what the emulation does not have:\n{}", finished.gaps);
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
            eprintln!("GDB: target remote {address}");
        }
        Ok(Some(listener))
    }
}

fn refusal(what: &dyn std::fmt::Display) -> Error {
    Error::Board(what.to_string())
}

/// The person at the keyboard.
struct Session {
    commands: Receiver<Command>,
    show: Show,
    started: Option<Instant>,
    angle_deg: Option<f64>,
    saving: Option<Saving>,
    period: u64,
}

impl Session {
    fn new(arguments: &Board) -> Self {
        let (typed, commands) = channel();
        // It ends with the program: nobody can make a read of the terminal return.
        std::thread::spawn(move || console::read(&typed));
        Self {
            commands,
            show: Show::new(arguments.format),
            started: (arguments.pace == Pace::Real).then(Instant::now),
            angle_deg: None,
            saving: None,
            period: 0,
        }
    }

    fn obey(&mut self, command: Command, view: &mut View<'_>) -> Flow {
        let now_ns = view.now_ns();
        match command {
            Command::End => return Flow::End,
            Command::Servo(pulse_us) => view.set_servo_us(pulse_us),
            Command::Angle(deg) => self.angle_deg = Some(deg),
            Command::SaveCapture(path) => self.saving = Some(Saving::new(path)),
            Command::Order(order) => {
                // Without a command the loop would be opened again by the command timeout.
                if order == console::ENABLE {
                    self.angle_deg.get_or_insert(0.0);
                }
                if let Some(port) = view.port(0) {
                    port.send(now_ns, console::frame(self.angle_deg.unwrap_or(0.0), order));
                }
            }
        }
        Flow::On
    }

    /// Reads on in the capture that is to be saved, if one is.
    fn save(&mut self, view: &mut View<'_>, heard: &[(u64, virtual_board::can::Frame)]) {
        let Some(saving) = &mut self.saving else {
            return;
        };
        match saving.go_on(self.period, heard) {
            Ok(frame) => {
                let now_ns = view.now_ns();
                if let (Some(port), Some(frame)) = (view.port(0), frame) {
                    port.send(now_ns, frame);
                }
            }
            Err(end) => {
                let word = match end {
                    Saved::Written(..) => "capture",
                    Saved::Unreadable(_) | Saved::Unwritable(_) => "error",
                };
                eprintln!("{word}: {end}");
                self.saving = None;
            }
        }
    }

    fn wait_for_the_wall(&self, now_ns: u64) {
        if let Some(started) = self.started {
            let due = started + Duration::from_nanos(now_ns);
            std::thread::sleep(due.saturating_duration_since(Instant::now()));
        }
    }
}

/// PWM periods from one command frame to the next: a tenth of a second would be the timeout.
const COMMAND_EVERY: u64 = 50;

impl Script for Session {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        self.period += 1;
        let now_ns = view.now_ns();
        // What is typed before the board has started waits for it.
        while self.show.is_started()
            && let Ok(command) = self.commands.try_recv()
        {
            if self.obey(command, view) == Flow::End {
                return Flow::End;
            }
        }
        if let (Some(deg), true) = (self.angle_deg, self.period.is_multiple_of(COMMAND_EVERY))
            && let Some(port) = view.port(0)
        {
            port.send(now_ns, console::frame(deg, console::NO_ORDER));
        }
        let heard = view
            .port(0)
            .map(|port| port.take_heard())
            .unwrap_or_default();
        self.save(view, &heard);
        let shown = self.show.row(view.row, self.angle_deg, &heard);
        self.wait_for_the_wall(now_ns);
        if shown { Flow::On } else { Flow::End }
    }
}
