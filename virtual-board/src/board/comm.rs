//! The communication board: the chip with a serial line and a CAN bus.

use rigless::machine::{Board, Target};
use rigless::mcu::Mcu;
use rigless::snapshot::Store;
use rigless::soc::Error;

use super::core;
use super::sleep::Sleep;
use super::spare_cores::CoreKind;
use crate::chip::{Chip, USART3};
use crate::flash::FlashTimes;
use crate::serial::SerialPeer;

/// Clock of the core, Hz.
pub const COMM_CORE_HZ: u64 = 160_000_000;

/// The communication board, on a shared CAN bus.
#[derive(Debug)]
pub struct CommBoard {
    /// The chip.
    pub chip: Chip,
    /// Sleep time of its core.
    pub(crate) sleep: Sleep,
}

// A run starts from power-on: snapshots are not used.
impl Store for CommBoard {}

impl CommBoard {
    /// A board after power-on.
    ///
    /// # Errors
    /// An error of rigless if the description of the chip is inconsistent.
    pub fn try_new() -> Result<Self, Error> {
        let mut chip = Chip::try_new(None, FlashTimes::TYPICAL, 0)?;
        chip.part.usart[USART3].attach(SerialPeer::default());
        Ok(Self {
            chip,
            sleep: Sleep::default(),
        })
    }

    /// The other end of the serial line.
    pub fn serial(&mut self) -> Option<&mut SerialPeer> {
        self.chip.part.usart[USART3].chip_mut()
    }
}

impl Board for CommBoard {
    fn name(&self) -> &'static str {
        "comm-board"
    }

    fn target_names(&self) -> Vec<&'static str> {
        vec![core::TARGET]
    }

    fn mcu(&mut self, target: usize) -> Option<&mut dyn Mcu> {
        (target == 0).then_some(&mut self.chip)
    }

    fn targets(&mut self) -> Vec<Target<'_>> {
        let kind = CoreKind {
            chip: core::TARGET,
            clock_hz: COMM_CORE_HZ,
            vector_table: None,
            protects_memory: false,
        };
        let spec = core::spec(&self.chip, &kind);
        spec.map(|spec| core::target(kind, &mut self.chip, spec, None, None, &self.sleep))
            .into_iter()
            .collect()
    }
}
