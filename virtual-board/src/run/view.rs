//! What a script sees of the run, and may do to it.

use rigless::emulator::Memory;
use rigless::soc::Width;
use rigless::time::VirtualNanos;

use super::servo::Servo;
use crate::board::ActuatorBoard;
use crate::can::{BxCan, Port};
use crate::faults::{Injector, Planned};
use crate::flash::Interface;
use crate::plant::BoardPlant;
use crate::trace::Row;

/// Whether a run goes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Flow {
    /// It does.
    On,
    /// It ends here.
    End,
}

/// What somebody does who sits beside the board.
pub trait Script: Send {
    /// At the start of every PWM period: the rig has moved to it, the pins show it, and the
    /// firmware has not seen it yet.
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow;
}

impl<F: FnMut(&mut View<'_>) -> Flow + Send> Script for F {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        self(view)
    }
}

/// The run, between two instructions.
pub struct View<'a> {
    /// What was traced last: the start of this period.
    pub row: &'a Row,
    /// The rig.
    pub rig: &'a mut BoardPlant,
    pub(super) now_ns: u64,
    pub(super) board: &'a mut ActuatorBoard,
    pub(super) memory: &'a mut dyn Memory,
    pub(super) faults: &'a mut Injector,
    pub(super) servo: &'a mut Servo,
    pub(super) resets: usize,
}

impl View<'_> {
    /// The virtual time, ns: some 5 us before the period that [`View::row`] names.
    pub fn now_ns(&self) -> u64 {
        self.now_ns
    }

    /// A station on the CAN bus.
    pub fn port(&mut self, index: usize) -> Option<&mut Port> {
        self.board.chip.can.wire.as_mut()?.ports.get_mut(index)
    }

    /// The CAN controller.
    pub fn can(&mut self) -> &mut BxCan {
        &mut self.board.chip.can
    }

    /// The flash.
    pub fn flash(&mut self) -> &mut Interface {
        &mut self.board.chip.flash
    }

    /// A word of memory; `None` where there is none.
    pub fn word(&mut self, address: u64) -> Option<u32> {
        let word = self.memory.read(address, Width::W32).ok()?;
        Some(word as u32)
    }

    /// A register of the chip, without the effects of a read.
    pub fn register(&mut self, address: u64) -> u32 {
        let at = VirtualNanos(self.now_ns);
        self.board.chip.peek_register(at, address) as u32
    }

    /// Puts a word into memory that the program cannot write, as a programmer puts it into the
    /// flash; whether there is such memory.
    pub fn program_word(&mut self, address: u64, word: u32) -> bool {
        let put = self.memory.program(address, Width::W32, word.into());
        put.is_ok()
    }

    /// Adds a fault to the plan.
    pub fn plan(&mut self, planned: Planned) {
        self.faults.add(planned);
    }

    /// Sets the length of the servo's pulses, us, or ends them.
    pub fn set_servo_us(&mut self, pulse_us: Option<f64>) {
        self.servo.set(self.now_ns, pulse_us);
    }

    /// Resets so far.
    pub fn resets(&self) -> usize {
        self.resets
    }
}
