//! The actuator board, with its encoder and its servo bus, and the communication board.

mod comm;
pub(crate) mod core;
mod crc_bus;
mod encoder_chip;
mod resettable;
mod sleep;
mod spare_cores;

use rigless::device::Level;
use rigless::machine::{Board, Target};
use rigless::mcu::Mcu;
use rigless::snapshot::Store;
use rigless::soc::Error;
use rigless::soc::stm32f427::peripherals::gpio::Pin;
use rigless::soc::stm32f427::peripherals::spi::Select;

pub use self::comm::{COMM_CORE_HZ, CommBoard};
pub use self::encoder_chip::EncoderChip;
pub(crate) use self::sleep::Sleep;
pub use self::spare_cores::CoreKind;
use crate::can::Wire;
use crate::chip::{ActuatorChip, Chip, ChipH743, USART1};
use crate::flash::FlashTimes;
use crate::plant::SsiWord;
use crate::processor::SharedObserver;
use crate::serial::SerialPeer;

/// Clock of the core of the STM32F427, Hz.
pub const CORE_HZ: u64 = 168_000_000;

/// The actuator management board.
#[derive(Debug)]
pub struct ActuatorBoard {
    /// The chip.
    pub chip: Box<dyn ActuatorChip>,
    /// Observes the core.
    pub observer: Option<SharedObserver>,
    /// Where the core finds its vector table after a reset, if that is not the start of the flash:
    /// a program that is linked for the slot of the bootloader runs without it.
    pub vector_table: Option<u32>,
    /// Whether the core has its memory protection unit.
    pub protects_memory: bool,
    /// Sleep time of its core.
    pub(crate) sleep: Sleep,
}

// A run starts from power-on: snapshots are not used.
impl Store for ActuatorBoard {}

/// The pin that selects the encoder: PA4.
pub(crate) const SELECT_PIN: u8 = 4;

/// The chip of an actuator board.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ChipKind {
    /// STM32F427.
    #[default]
    F427,
    /// STM32H743.
    H743,
}

impl ActuatorBoard {
    /// A board after power-on, on its own CAN bus or on a shared one.
    ///
    /// # Errors
    /// An error of rigless if the description of the chip is inconsistent.
    pub fn try_new(
        kind: ChipKind,
        wire: Option<Wire>,
        times: FlashTimes,
        seed: u64,
    ) -> Result<Self, Error> {
        let chip: Box<dyn ActuatorChip> = match kind {
            ChipKind::F427 => Box::new(with_peers(Chip::try_new(wire, times, seed)?)),
            ChipKind::H743 => Box::new(ChipH743::try_new(wire)?),
        };
        Ok(Self {
            chip,
            observer: None,
            vector_table: None,
            protects_memory: false,
            sleep: Sleep::default(),
        })
    }

    /// Sets the word of the next encoder transfer.
    pub fn set_encoder(&mut self, word: SsiWord) {
        if let Some(encoder) = self.chip.encoder() {
            encoder.word = word;
        }
    }

    /// Number of encoder transfers.
    pub fn encoder_reads(&mut self) -> u64 {
        self.chip.encoder().map_or(0, |encoder| encoder.reads)
    }
}

/// Connects the encoder to SPI1, and the servo bus to USART1.
fn with_peers(mut chip: Chip) -> Chip {
    if let Some(pin) = Pin::new(SELECT_PIN) {
        let select = Select {
            port: "GPIOA",
            pin,
            active: Level::Low,
        };
        chip.part.spi[0].attach_selected(EncoderChip::default(), select);
    }
    chip.part.usart[USART1].attach(SerialPeer::default());
    chip
}

const NAME: &str = "actuator-board";

impl Board for ActuatorBoard {
    fn name(&self) -> &'static str {
        NAME
    }

    fn target_names(&self) -> Vec<&'static str> {
        vec![self.chip.name()]
    }

    fn mcu(&mut self, target: usize) -> Option<&mut dyn Mcu> {
        (target == 0).then_some(self.chip.as_mut())
    }

    fn targets(&mut self) -> Vec<Target<'_>> {
        let observer = self.observer.clone();
        let kind = CoreKind {
            chip: self.chip.name(),
            clock_hz: self.chip.core_hz(),
            vector_table: self.vector_table,
            protects_memory: self.protects_memory,
        };
        let spec = self.chip.core(&kind);
        let crc = self.chip.crc_remainder();
        let mcu: &mut dyn Mcu = self.chip.as_mut();
        spec.map(|spec| core::target(kind, mcu, spec, observer, crc, &self.sleep))
            .into_iter()
            .collect()
    }
}
