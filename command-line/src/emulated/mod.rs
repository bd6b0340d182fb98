//! Emulated actuator boards and the emulated communication board on one CAN bus, in real time.
//!
//! Each board runs its ELF in its own thread; the bus connects them. Clients use the serial
//! line of the communication board, which has one client at a time.

mod bootloader;
mod transport;

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::thread;

use firmware::drive::StoredParameters;
use firmware::store::first_page;
use model_core::plant::board::BoardPlantOptions;
use virtual_board::board::ChipKind;
use virtual_board::faults::Planned;
use virtual_board::flash::{FlashTimes, Sector};
use virtual_board::run::{
    Attachments, BusConnection, CommOptions, CommView, Firmware, FirmwareError, Flow, Gaps,
    Options, Reset, SerialScript, SharedBus, run_comm, run_with,
};

use self::bootloader::{Bootloader, Keeper};
use crate::bounded::{self, MOST_BUILD};
use crate::error::Error;

pub use bootloader::BootOptions;
pub use transport::{TcpServer, Terminal, Transport};

/// Address of the unique device identifier, the source of the serial number (RM0090, section 39.1;
/// RM0433, section 61.1).
const fn unique_id(chip: ChipKind) -> u64 {
    match chip {
        ChipKind::F427 => 0x1fff_7a10,
        ChipKind::H743 => 0x1ff1_e800,
    }
}

/// Time between two polls of the client, ns of virtual time.
const POLL_NS: u64 = 500_000;

/// Bytes in the receive buffer of the line; the operating system buffers more and blocks the
/// client.
const RECEIVE_BUFFER: usize = 256;

/// Bytes in the send buffer of the client; further lines are lost.
const SEND_BUFFER: usize = 1 << 16;

/// End of an unlimited run: centuries.
const FOR_EVER_NS: u64 = u64::MAX / 2;

/// The programs of the boards.
pub struct Programs {
    actuator: Firmware,
    boot: Option<Bootloader>,
    faults: Vec<Planned>,
    chip: ChipKind,
    comm: Firmware,
    has_dronecan: bool,
}

impl Programs {
    /// Reads the ELF files. The faults are those of the first board. The protocol of the boards is
    /// CANopen or DroneCAN.
    ///
    /// # Errors
    /// For a file that is not the program of its board.
    pub fn read(
        actuator: &Path,
        comm: &Path,
        boot: &BootOptions<'_>,
        faults: Vec<Planned>,
        has_dronecan: bool,
    ) -> Result<Self, Error> {
        let board = |error: FirmwareError| Error::Board(error.to_string());
        let (program, comm) = (firmware(actuator)?, firmware(comm)?);
        comm.check_comm_board().map_err(board)?;
        let chip = program.actuator_chip().map_err(board)?;
        Ok(Self {
            boot: Bootloader::read(boot, actuator, chip)?,
            actuator: program,
            faults,
            chip,
            comm,
            has_dronecan,
        })
    }
}

/// Reads the ELF file of a board's program.
///
/// # Errors
/// For a file that cannot be read or is not an ELF file.
pub fn firmware(path: &Path) -> Result<Firmware, Error> {
    let bytes = bounded::read(path, MOST_BUILD)?;
    Firmware::of(path, bytes).map_err(|error| Error::Board(error.to_string()))
}

/// Runs one board for each of these plants, with node-IDs and serial numbers from 1, and the
/// communication board, until `stop` is set; calls `ready` once all have started.
///
/// # Errors
/// Those of the emulator.
pub fn serve(
    programs: &Programs,
    plants: &[BoardPlantOptions],
    transport: Box<dyn Transport>,
    ready: Box<dyn FnOnce() + Send>,
    stop: &Arc<AtomicBool>,
) -> Result<(), String> {
    let bus = SharedBus::new(Vec::new(), plants.len() + 1).in_real_time();
    let mut connections = bus.connections().into_iter();
    thread::scope(|scope| {
        let mut boards = Vec::new();
        for (number, (plant, connection)) in (1..).zip(plants.iter().zip(&mut connections)) {
            let run = move || {
                let _stop_on_end = StopOnDrop(stop);
                run_actuator(programs, number, plant, connection, stop)
            };
            boards.push(scope.spawn(run));
        }
        let connection = connections.next();
        let stop_on_end = StopOnDrop(stop);
        let line = SerialLine {
            transport,
            unread: Vec::new(),
            is_skipping: false,
            ready: Some(ready),
        };
        let mut done = connection.map_or(Ok(()), |connection| {
            run_comm_board(&programs.comm, connection, line, stop)
        });
        drop(stop_on_end);
        for board in boards {
            let ended = board
                .join()
                .unwrap_or_else(|_| Err("a board's run has failed".into()));
            done = done.and(ended);
        }
        done
    })
}

/// Stops all runs when one connections: the chain needs every board.
struct StopOnDrop<'a>(&'a AtomicBool);

impl Drop for StopOnDrop<'_> {
    fn drop(&mut self) {
        self.0.store(true, Relaxed);
    }
}

fn run_actuator(
    programs: &Programs,
    number: i32,
    plant: &BoardPlantOptions,
    connection: BusConnection,
    stop: &Arc<AtomicBool>,
) -> Result<(), String> {
    let contents = identity(programs, number);
    let boot = programs.boot.as_ref();
    let options = Options {
        chip: programs.chip,
        plant: *plant,
        ports_bit_s: Vec::new(),
        contents: match boot {
            Some(boot) => boot.flash(number, contents)?,
            None => contents,
        },
        // While the bootloader waits for an erase it executes the instructions of a minute.
        flash_times: boot.map_or(FlashTimes::TYPICAL, |_| FlashTimes::SHORT_ERASE),
        faults: match number {
            1 => programs.faults.clone(),
            _ => Vec::new(),
        },
        keeps_trace: false,
        until_ns: FOR_EVER_NS,
        ..Options::for_ms(0)
    };
    let file = boot.and_then(|boot| boot.file(number));
    let attachments = Attachments {
        // A board whose flash is kept ends by itself.
        interrupt: file.is_none().then(|| Arc::clone(stop)),
        bus: Some(connection),
        ..Attachments::default()
    };
    let script = Keeper {
        stop: Arc::clone(stop),
        file,
        error: None,
    };
    let program = boot.map_or(&programs.actuator, |boot| &boot.firmware);
    let finished =
        run_with(program, options, script, attachments).map_err(|error| error.to_string())?;
    report(
        &format!("actuator {number}"),
        &finished.resets,
        &finished.gaps,
    );
    match finished.script.error {
        Some(error) => Err(error.to_string()),
        None => Ok(()),
    }
}

/// Memory contents that set the number of a board: stored parameters, in the first sector of bank 2
/// of either chip, and device identifier.
fn identity(programs: &Programs, number: i32) -> Vec<(u64, Vec<u8>)> {
    let mut parameters = StoredParameters::DEFAULT;
    parameters.board.bus.node_id = number;
    if programs.has_dronecan {
        parameters = parameters.with_dronecan(number as u8);
    }
    let bytes = |words: &[u32]| words.iter().flat_map(|word| word.to_le_bytes()).collect();
    let page = Sector::of_number(12).map(|sector| (sector.base, bytes(&first_page(&parameters))));
    let id = (
        unique_id(programs.chip),
        bytes(&[number.cast_unsigned(), 0, 0]),
    );
    page.into_iter().chain([id]).collect()
}

fn run_comm_board(
    program: &Firmware,
    bus: BusConnection,
    line: SerialLine,
    stop: &Arc<AtomicBool>,
) -> Result<(), String> {
    let options = CommOptions {
        bus,
        poll_ns: POLL_NS,
        until_ns: FOR_EVER_NS,
        interrupt: Some(Arc::clone(stop)),
    };
    let finished = run_comm(program, options, line).map_err(|error| error.to_string())?;
    report("communication board", &finished.resets, &finished.gaps);
    Ok(())
}

/// The serial line and its client.
struct SerialLine {
    transport: Box<dyn Transport>,
    unread: Vec<u8>,
    is_skipping: bool,
    /// Called when the boards have started.
    ready: Option<Box<dyn FnOnce() + Send>>,
}

/// Time at which all boards have started, ns.
const STARTED_NS: u64 = 50_000_000;

impl SerialLine {
    /// Buffers a byte for the client; if the client does not read, whole lines are lost.
    fn buffer(&mut self, byte: u8) {
        if self.is_skipping {
            self.is_skipping = byte != b'\r';
            return;
        }
        self.unread.push(byte);
        if self.unread.len() > SEND_BUFFER {
            let last_end = self.unread.iter().rposition(|byte| *byte == b'\r');
            self.unread.truncate(last_end.map_or(0, |end| end + 1));
            self.is_skipping = byte != b'\r';
        }
    }
}

impl SerialScript for SerialLine {
    fn at_poll(&mut self, view: &mut CommView<'_>) -> Flow {
        let now_ns = view.now_ns();
        if now_ns >= STARTED_NS
            && let Some(ready) = self.ready.take()
        {
            ready();
        }
        let Some(serial) = view.serial() else {
            return Flow::End;
        };
        for (_, byte) in serial.take_received() {
            self.buffer(byte);
        }
        self.transport.write(&mut self.unread);
        let mut bytes = [0; RECEIVE_BUFFER];
        if serial.queued() < RECEIVE_BUFFER {
            let count = self.transport.read(&mut bytes);
            serial.send(now_ns, bytes.get(..count).unwrap_or_default());
        }
        Flow::Continue
    }
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
