//! Runs an ELF file on the emulated boards.

mod board_faults;
mod client;
mod comm;
mod driver;
mod finished;
mod firmware;
mod grid;
mod options;
mod places;
mod probe;
mod servo;
mod shared;
mod view;

use std::net::TcpListener;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use rigless::emulator::{self, Start};
use rigless::session::Session;
use rigless::time::VirtualNanos;

pub use client::{ClientSide, Requests, RunSide, client};
pub use comm::{CommFinished, CommOptions, CommView, SerialScript, run_comm};
pub use finished::{Finished, Gaps};
pub use firmware::{Firmware, FirmwareError, Handler};
pub use options::Options;
pub use probe::Span;
pub use rigless::device::ResetCause;
pub use rigless::session::Reset;
pub use shared::{BusConnection, QUANTUM_NS, SharedBus};
pub use view::{Flow, Script, View};

use self::driver::Lockstep;
use crate::board::ActuatorBoard;
use crate::can::{Port, Wire};
use crate::processor::SharedObserver;

/// Reason why a run failed.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// A parameter of the plant is outside its range.
    #[error(transparent)]
    Plant(#[from] model_core::parameter::ParameterError),
    /// The ELF file lacks a name that a probe or a fault refers to.
    #[error(transparent)]
    Firmware(#[from] FirmwareError),
    /// A fault changes a bit where there is no such memory.
    #[error("there is no {memory} at {address:#x}, expected {expected}")]
    Place {
        /// RAM or flash.
        memory: &'static str,
        /// The address of the byte.
        address: u64,
        /// Where there is such memory.
        expected: String,
    },
    /// An error of the emulator.
    #[error("the emulator: {0}")]
    Emulator(#[from] emulator::Error),
    /// The description of the chip is inconsistent.
    #[error("the chip: {0}")]
    Chip(#[from] rigless::soc::Error),
}

/// Optional attachments of a run: a debugger, a flag that ends it, a shared bus, an observer.
#[derive(Debug, Default)]
pub struct Attachments {
    /// Serves GDB here; the core is halted until GDB continues it.
    pub debugger: Option<TcpListener>,
    /// Ends the run when it is set.
    pub interrupt: Option<Arc<AtomicBool>>,
    /// The board's connection to a shared bus. The run has no ports of its own then.
    pub bus: Option<BusConnection>,
    /// Observes the core.
    pub observer: Option<SharedObserver>,
}

/// Runs a firmware until its time has passed or the script ends it.
///
/// # Errors
/// A parameter outside its range, a name that the ELF file does not have, a fault where there is no
/// memory, or an error of the emulator.
pub fn run<S: Script + 'static>(
    firmware: &Firmware,
    options: Options,
    script: S,
) -> Result<Finished<S>, RunError> {
    run_with(firmware, options, script, Attachments::default())
}

/// As [`run`], with attachments.
///
/// # Errors
/// As [`run`].
pub fn run_with<S: Script + 'static>(
    firmware: &Firmware,
    options: Options,
    script: S,
    attachments: Attachments,
) -> Result<Finished<S>, RunError> {
    let ports = options
        .ports_bit_s
        .iter()
        .map(|bit_s| Port::at_rate(*bit_s));
    let is_shared = attachments.bus.is_some();
    let wire = (!is_shared).then(|| Wire::new(ports.collect()));
    let mut board =
        ActuatorBoard::try_new(options.chip, wire, options.flash_times, options.plant.seed)?;
    places::check(&options.faults, firmware, board.chip.ram())?;
    board.observer = attachments.observer;
    board.vector_table = firmware.vector_table();
    board.protects_memory = options.protects_memory;
    let contents = options.contents.clone();
    let driver = Lockstep::try_new(firmware, options, script, attachments.bus)?;
    let until = VirtualNanos(driver.next_ns(0));
    let session = Session::new(Box::new(board), 0, until)?;
    let mut images = vec![firmware.image()?];
    for (address, bytes) in contents {
        images.push(firmware::contents(address, bytes)?);
    }
    let mut start = Start::new(&images);
    start.debugger = attachments.debugger.as_ref();
    start.wait_for_debugger = attachments.debugger.is_some();
    start.interrupt = attachments.interrupt.as_deref();
    let finished = emulator::run(session, &start, driver)?;
    Ok(Finished::of(finished))
}
