//! Runs the communication board's ELF, on a bus that it may share with actuator boards.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use rigless::emulator::{self, Driver, Host, Memory, Start, Stop};
use rigless::session::{Reset, Session};
use rigless::soc::Width;
use rigless::time::VirtualNanos;

use super::finished::Gaps;
use super::shared::BusConnection;
use super::view::Flow;
use super::{Firmware, RunError};
use crate::board::CommBoard;
use crate::can::BxCan;
use crate::chip::ActuatorChip;
use crate::serial::SerialPeer;

/// Options of a run.
#[derive(Debug)]
pub struct CommOptions {
    /// The board's connection to the bus.
    pub bus: BusConnection,
    /// Period of the calls of the script, ns.
    pub poll_ns: u64,
    /// End of the run, ns of virtual time.
    pub until_ns: u64,
    /// Ends the run when it is set.
    pub interrupt: Option<Arc<AtomicBool>>,
}

/// Plays the peer of the communication board on its serial line.
pub trait SerialScript: Send {
    /// Called once in each poll period.
    fn at_poll(&mut self, view: &mut CommView<'_>) -> Flow;
}

impl<F: FnMut(&mut CommView<'_>) -> Flow + Send> SerialScript for F {
    fn at_poll(&mut self, view: &mut CommView<'_>) -> Flow {
        self(view)
    }
}

/// A script's access to the run between two instructions.
pub struct CommView<'a> {
    now_ns: u64,
    board: &'a mut CommBoard,
    memory: &'a mut dyn Memory,
}

impl CommView<'_> {
    /// The virtual time, ns.
    pub fn now_ns(&self) -> u64 {
        self.now_ns
    }

    /// The peer on the serial line.
    pub fn serial(&mut self) -> Option<&mut SerialPeer> {
        self.board.serial()
    }

    /// The CAN controller.
    pub fn can(&mut self) -> &mut BxCan {
        &mut self.board.chip.can
    }

    /// A register of the chip, without the side effects of a read.
    pub fn register(&mut self, address: u64) -> u32 {
        let at = VirtualNanos(self.now_ns);
        self.board.chip.peek_register(at, address) as u32
    }

    /// A word of memory; `None` where no memory is mapped.
    pub fn word(&mut self, address: u64) -> Option<u32> {
        let word = self.memory.read(address, Width::W32).ok()?;
        Some(word as u32)
    }
}

/// A finished run.
#[derive(Debug)]
pub struct CommFinished<S> {
    /// The script.
    pub script: S,
    /// Accesses that the emulation does not model.
    pub gaps: Gaps,
    /// Every reset and its cause.
    pub resets: Vec<Reset>,
    /// Virtual time at the end, ns.
    pub end_ns: u64,
}

#[derive(Debug)]
struct CommRun<S> {
    script: S,
    options: CommOptions,
    next_poll_ns: u64,
    last_ns: u64,
}

impl<S: SerialScript> Driver<CommBoard> for CommRun<S> {
    fn on_stop(
        &mut self,
        session: &mut Session<CommBoard>,
        stop: Stop,
        host: &mut dyn Host,
    ) -> Option<VirtualNanos> {
        let now_ns = stop.at.0;
        self.last_ns = now_ns;
        let mut flow = Flow::Continue;
        let has_acted = now_ns >= self.next_poll_ns;
        if now_ns >= self.next_poll_ns {
            self.next_poll_ns += self.options.poll_ns.max(1);
            flow = self.script.at_poll(&mut CommView {
                now_ns,
                board: session.board_mut(),
                memory: host,
            });
        }
        let sleep = session.board().sleep.clone();
        let quiet_until_ns = sleep.quiet_until_ns(session.mcu(), has_acted, self.next_poll_ns);
        let bus = &mut self.options.bus;
        bus.synchronise(&mut session.board_mut().chip, stop.at, quiet_until_ns);
        if flow == Flow::End || now_ns >= self.options.until_ns {
            return None;
        }
        let next_ns = bus.next_ns().min(self.next_poll_ns);
        let next_ns = next_ns.min(self.options.until_ns);
        Some(VirtualNanos(next_ns.max(now_ns + 1)))
    }
}

/// Runs a firmware on the communication board until its time has passed or the script ends it.
///
/// # Errors
/// An error of the emulator.
pub fn run_comm<S: SerialScript + 'static>(
    firmware: &Firmware,
    options: CommOptions,
    script: S,
) -> Result<CommFinished<S>, RunError> {
    let board = CommBoard::try_new()?;
    let interrupt = options.interrupt.clone();
    let driver = CommRun {
        script,
        next_poll_ns: options.poll_ns,
        options,
        last_ns: 0,
    };
    let until = VirtualNanos(1);
    let session = Session::new(Box::new(board), 0, until)?;
    let images = [firmware.image()?];
    let mut start = Start::new(&images);
    start.interrupt = interrupt.as_deref();
    let finished = emulator::run(session, &start, driver)?;
    Ok(CommFinished {
        gaps: Gaps::of(&finished.session),
        resets: finished.session.resets().to_vec(),
        end_ns: finished.driver.last_ns,
        script: finished.driver.script,
    })
}
