//! A script's access to the run.

use rigless::emulator::Memory;
use rigless::soc::Width;
use rigless::time::VirtualNanos;

use super::servo::Servo;
use crate::board::ActuatorBoard;
use crate::can::Port;
use crate::faults::{Injector, Planned};
use crate::flash::Interface;
use crate::plant::BoardPlant;
use crate::serial::SerialPeer;
use crate::trace::Row;

/// Whether a run continues.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Flow {
    /// It continues.
    Continue,
    /// It ends.
    End,
}

/// Actions on a run from outside the board.
pub trait Script: Send {
    /// Called at the start of every PWM period: the plant has advanced to it, the pins are set, and
    /// the firmware has not run yet.
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow;

    /// Called every 0.1 ms while the timer of the bridge does not run, as in a bootloader; with
    /// [`Options::polls_at_stops`](super::Options::polls_at_stops), at every stop of the run.
    fn at_poll(&mut self, _: &mut View<'_>) -> Flow {
        Flow::Continue
    }
}

impl<F: FnMut(&mut View<'_>) -> Flow + Send> Script for F {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        self(view)
    }
}

/// Access to the run between two instructions.
pub struct View<'a> {
    /// The last row of the trace: the start of this period.
    pub row: &'a Row,
    /// The plant.
    pub plant: &'a mut BoardPlant,
    pub(super) now_ns: u64,
    pub(super) board: &'a mut ActuatorBoard,
    pub(super) memory: &'a mut dyn Memory,
    pub(super) faults: &'a mut Injector,
    pub(super) servo: &'a mut Servo,
    pub(super) resets: usize,
}

impl View<'_> {
    /// The virtual time, ns: some 5 us before the start of the period in [`View::row`].
    pub fn now_ns(&self) -> u64 {
        self.now_ns
    }

    /// A station on the CAN bus.
    pub fn port(&mut self, index: usize) -> Option<&mut Port> {
        self.board.chip.wire()?.ports.get_mut(index)
    }

    /// The other end of the servo bus.
    pub fn servo_bus(&mut self) -> Option<&mut SerialPeer> {
        self.board.chip.servo_bus()
    }

    /// The flash of an STM32F427.
    pub fn flash(&mut self) -> Option<&mut Interface> {
        self.board.chip.flash()
    }

    /// A word of memory; `None` where no memory is mapped.
    pub fn word(&mut self, address: u64) -> Option<u32> {
        let word = self.memory.read(address, Width::W32).ok()?;
        Some(word as u32)
    }

    /// A register of the chip, without the side effects of a read.
    pub fn register(&mut self, address: u64) -> u32 {
        let at = VirtualNanos(self.now_ns);
        self.board.chip.peek_register(at, address) as u32
    }

    /// Writes a word into the flash as a debug probe does; returns whether the address is
    /// mapped.
    pub fn program_word(&mut self, address: u64, word: u32) -> bool {
        let put = self.memory.program(address, Width::W32, word.into());
        put.is_ok()
    }

    /// Plans a fault.
    pub fn plan(&mut self, planned: Planned) {
        self.faults.add(planned);
    }

    /// Sets the width of the servo pulses, us, or ends them.
    pub fn set_servo_us(&mut self, pulse_us: Option<f64>) {
        self.servo.set(self.now_ns, pulse_us);
    }

    /// Number of resets so far.
    pub fn resets(&self) -> usize {
        self.resets
    }
}
