//! Emulated actuator boards, native actuators and the emulated communication board on one CAN bus,
//! in real time; or emulated actuator boards on a servo bus (`servos`).
//!
//! Each board runs its ELF in its own thread; the bus connects them. Clients use the serial
//! line of the communication board, which has one client at a time.

mod bootloader;
mod line;
mod native;
mod programs;
mod servo_line;
mod servos;
mod transport;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::mpsc::{self, Receiver};
use std::thread::{self, ScopedJoinHandle};

use firmware::drive::StoredParameters;
use firmware::store::first_page;
use host_sim::can::node_fault::{Change, Fault};
use model_core::plant::board::BoardPlantOptions;
use virtual_board::board::ChipKind;
use virtual_board::can::Port;
use virtual_board::flash::{FlashTimes, Sector};
use virtual_board::run::{
    Attachments, BusConnection, Firmware, Gaps, Options, Reset, Script, SharedBus, run_with,
};

use self::bootloader::Keeper;
use self::line::SerialLine;
use self::native::NativeActuators;
use self::programs::Program;

pub use bootloader::BootOptions;
pub use programs::{Interface, Programs, comm_board, firmware};
pub use servos::{on_boards, serve_servos};
pub use transport::{TcpServer, Terminal, Transport};

/// Address of the unique device identifier, the source of the serial number (RM0090, section 39.1;
/// RM0433, section 61.1).
const fn unique_id(chip: ChipKind) -> u64 {
    match chip {
        ChipKind::F427 => 0x1fff_7a10,
        ChipKind::H743 => 0x1ff1_e800,
    }
}

/// End of an unlimited run: centuries.
const FOR_EVER_NS: u64 = u64::MAX / 2;

/// Bit rate of the bus of native actuators: that of new boards.
const BIT_S: u32 = 1_000_000;

/// Runs an actuator for each of these plants, with node-IDs and serial numbers from 1, and the
/// communication board, until `stop` is set; calls `ready` once all have started. The faults are
/// applied as they come.
///
/// # Errors
/// Those of the emulator.
pub fn serve(
    (programs, comm): (&Programs, &Firmware),
    plants: &[BoardPlantOptions],
    faults: Option<Receiver<Fault>>,
    transport: Box<dyn Transport>,
    ready: Box<dyn FnOnce() + Send>,
    stop: &Arc<AtomicBool>,
) -> Result<(), String> {
    let mut emulated = Vec::new();
    let mut native = Vec::new();
    let faults = distributed(faults.into_iter().flatten(), plants.len());
    for ((number, plant), faults) in (1..).zip(plants).zip(faults) {
        match programs.of(number) {
            Some(program) => emulated.push((number, program, plant, faults)),
            None => native.push((number, *plant, faults)),
        }
    }
    let ports = vec![Port::at_rate(BIT_S); native.len()];
    let bus = SharedBus::new(ports, emulated.len() + 1).in_real_time();
    let has_dronecan = programs.interface == Interface::DroneCan;
    let native = NativeActuators::new(bus.clone(), native, has_dronecan)?;
    let mut connections = bus.connections().into_iter();
    thread::scope(|scope| {
        let mut boards = Vec::new();
        for (board, connection) in emulated.into_iter().zip(&mut connections) {
            let run = move || {
                let _stop_on_end = StopOnDrop(stop);
                let (number, program, plant, faults) = board;
                let options = options(programs, program, number, plant)?;
                let script = Keeper::new((program, number), faults, stop);
                run_board((program, number), options, script, connection, stop)?.into_result()
            };
            boards.push(scope.spawn(run));
        }
        let connection = connections.next();
        let stop_on_end = StopOnDrop(stop);
        let line = SerialLine::new(transport, native, ready);
        let done = connection.map_or(Ok(()), |connection| line::run(comm, connection, line, stop));
        drop(stop_on_end);
        done.and(joined(boards))
    })
}

/// Waits for the ends of runs.
///
/// # Errors
/// The first one.
fn joined(boards: Vec<ScopedJoinHandle<'_, Result<(), String>>>) -> Result<(), String> {
    let ended = boards.into_iter().map(|board| {
        let ended = board.join();
        ended.unwrap_or_else(|_| Err("a board's run has failed".into()))
    });
    // All of them end before the first error is returned.
    ended.fold(Ok(()), Result::and)
}

/// The faults of each of so many actuators, as they come.
fn distributed(
    faults: impl Iterator<Item = Fault> + Send + 'static,
    count: usize,
) -> Vec<Receiver<Change>> {
    let (senders, receivers): (Vec<_>, Vec<_>) = (0..count).map(|_| mpsc::channel()).unzip();
    thread::spawn(move || {
        for fault in faults {
            let sender = senders.get(fault.node - 1);
            // A board that has ended has none.
            sender.map(|sender| sender.send(fault.change));
        }
    });
    receivers
}

/// Stops all runs when one ends: the chain needs every board.
struct StopOnDrop<'a>(&'a AtomicBool);

impl Drop for StopOnDrop<'_> {
    fn drop(&mut self) {
        self.0.store(true, Relaxed);
    }
}

fn options(
    programs: &Programs,
    program: &Program,
    number: u8,
    plant: &BoardPlantOptions,
) -> Result<Options, String> {
    let contents = identity(program.chip, number, programs.interface);
    let boot = program.boot.as_ref();
    Ok(Options {
        chip: program.chip,
        plant: *plant,
        ports_bit_s: Vec::new(),
        contents: match boot {
            Some(boot) => boot.flash(number, contents)?,
            None => contents,
        },
        // While the bootloader waits for an erase it executes the instructions of a minute.
        flash_times: boot.map_or(FlashTimes::TYPICAL, |_| FlashTimes::SHORT_ERASE),
        faults: programs.faults(number),
        keeps_trace: false,
        until_ns: FOR_EVER_NS,
        ..Options::for_ms(0)
    })
}

/// Runs a board with this script until its end, and returns the script.
///
/// # Errors
/// Those of the emulator.
fn run_board<S: Script + 'static>(
    (program, number): (&Program, u8),
    options: Options,
    script: S,
    connection: BusConnection,
    stop: &Arc<AtomicBool>,
) -> Result<S, String> {
    let boot = program.boot.as_ref();
    let file = boot.and_then(|boot| boot.file(number));
    let attachments = Attachments {
        // A board whose flash is kept ends by itself.
        interrupt: file.is_none().then(|| Arc::clone(stop)),
        bus: Some(connection),
        ..Attachments::default()
    };
    let program = boot.map_or(&program.firmware, |boot| &boot.firmware);
    let finished =
        run_with(program, options, script, attachments).map_err(|error| error.to_string())?;
    report(
        &format!("actuator {number}"),
        &finished.resets,
        &finished.gaps,
    );
    Ok(finished.script)
}

/// Memory contents that set the number of a board: stored parameters, in the first sector of bank 2
/// of either chip, and device identifier.
fn identity(chip: ChipKind, number: u8, interface: Interface) -> Vec<(u64, Vec<u8>)> {
    let mut parameters = StoredParameters::DEFAULT;
    parameters.board.bus.node_id = number.into();
    let parameters = match interface {
        Interface::CanOpen => parameters,
        Interface::DroneCan => parameters.with_dronecan(number),
        Interface::ServoBus(model) => parameters.with_servo_bus(model, number),
    };
    let bytes = |words: &[u32]| words.iter().flat_map(|word| word.to_le_bytes()).collect();
    let page = Sector::of_number(12).map(|sector| (sector.base, bytes(&first_page(&parameters))));
    let id = (unique_id(chip), bytes(&[number.into(), 0, 0]));
    page.into_iter().chain([id]).collect()
}

/// Reports unexpected resets and gaps of the emulation.
fn report(board: &str, resets: &[Reset], gaps: &Gaps) {
    for reset in resets {
        let ms = reset.at.0 / 1_000_000;
        note!("{board}: reset at {ms} ms: {:?}", reset.cause);
    }
    if !gaps.is_empty() {
        note!("{board}: not emulated:\n{gaps}");
    }
}
