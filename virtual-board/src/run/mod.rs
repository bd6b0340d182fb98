//! Runs an ELF on the board.

mod comm;
mod driver;
mod faulty;
mod finished;
mod firmware;
mod grid;
mod options;
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

pub use comm::{CommFinished, CommOptions, CommView, Desk, run_comm};
pub use finished::{Finished, Gaps};
pub use firmware::{Firmware, FirmwareError};
pub use options::Options;
pub use probe::Span;
pub use rigless::device::ResetCause;
pub use rigless::session::Reset;
pub use shared::{BusEnd, QUANTUM_NS, SharedBus};
pub use view::{Flow, Script, View};

use self::driver::Lockstep;
use crate::board::ActuatorBoard;
use crate::can::{Port, Wire};

/// Why a run did not come about.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// A parameter of the rig is outside its range.
    #[error(transparent)]
    Rig(#[from] model_core::parameter::ParameterError),
    /// A function that a probe or a fault names is not in the ELF file.
    #[error(transparent)]
    Firmware(#[from] FirmwareError),
    /// The emulator refuses.
    #[error("the emulator: {0}")]
    Emulator(#[from] emulator::Error),
    /// The chip's description does not hold together.
    #[error("the chip: {0}")]
    Chip(#[from] rigless::soc::Error),
}

/// What stands beside a run: a debugger, and somebody who may end it.
#[derive(Debug, Default)]
pub struct Company {
    /// Serves GDB here, and holds the core until it continues.
    pub debugger: Option<TcpListener>,
    /// Ends the run once it is set.
    pub interrupt: Option<Arc<AtomicBool>>,
    /// The board's end of a bus that others share. Its own ports are none then.
    pub bus: Option<BusEnd>,
}

/// Runs a firmware until its time is over or the script ends it.
///
/// # Errors
/// A parameter outside its range, a name that the ELF file does not have, or what the emulator
/// refuses.
pub fn run<S: Script + 'static>(
    firmware: &Firmware,
    options: Options,
    script: S,
) -> Result<Finished<S>, RunError> {
    run_with(firmware, options, script, Company::default())
}

/// The same in company.
///
/// # Errors
/// As [`run`].
pub fn run_with<S: Script + 'static>(
    firmware: &Firmware,
    options: Options,
    script: S,
    company: Company,
) -> Result<Finished<S>, RunError> {
    let ports = options
        .ports_bit_s
        .iter()
        .map(|bit_s| Port::at_rate(*bit_s));
    let is_shared = company.bus.is_some();
    let wire = (!is_shared).then(|| Wire::new(ports.collect()));
    let board = ActuatorBoard::try_new(wire, options.flash_times, options.rig.seed)?;
    let contents = options.contents.clone();
    let driver = Lockstep::try_new(firmware, options, script, company.bus)?;
    let until = VirtualNanos(driver.next_ns(0));
    let session = Session::new(Box::new(board), 0, until)?;
    let mut images = vec![firmware.image()?];
    for (address, bytes) in contents {
        images.push(firmware::contents(address, bytes)?);
    }
    let mut start = Start::new(&images);
    start.debugger = company.debugger.as_ref();
    start.wait_for_debugger = company.debugger.is_some();
    start.interrupt = company.interrupt.as_deref();
    let finished = emulator::run(session, &start, driver)?;
    Ok(Finished::of(finished))
}
