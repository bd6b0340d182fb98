//! The actuator board, with its encoder, and the communication board.

mod comm;
mod core;
mod encoder_chip;
mod resettable;

use rigless::device::Level;
use rigless::machine::{Board, Target};
use rigless::mcu::Mcu;
use rigless::snapshot::Store;
use rigless::soc::Error;
use rigless::soc::stm32f427::peripherals::gpio::Pin;
use rigless::soc::stm32f427::peripherals::spi::Select;

pub use self::comm::{COMM_CORE_HZ, CommBoard};
use self::encoder_chip::EncoderChip;
use crate::can::Wire;
use crate::chip::Chip;
use crate::flash::FlashTimes;
use crate::plant::SsiWord;
use crate::processor::SharedObserver;

/// Clock of the core, Hz.
pub const CORE_HZ: u64 = 168_000_000;

/// The actuator management board.
#[derive(Debug)]
pub struct ActuatorBoard {
    /// The chip.
    pub chip: Chip,
    /// Observes the core.
    pub observer: Option<SharedObserver>,
}

// A run starts from power-on: snapshots are not used.
impl Store for ActuatorBoard {}

/// The pin that selects the encoder: PA4.
const SELECT_PIN: u8 = 4;

impl ActuatorBoard {
    /// A board after power-on, on a CAN bus of its own or on a shared one.
    ///
    /// # Errors
    /// An error of rigless if the description of the chip is inconsistent.
    pub fn try_new(wire: Option<Wire>, times: FlashTimes, seed: u64) -> Result<Self, Error> {
        let mut chip = Chip::try_new(wire, times, seed)?;
        if let Some(pin) = Pin::new(SELECT_PIN) {
            let select = Select {
                port: "GPIOA",
                pin,
                active: Level::Low,
            };
            chip.part.spi[0].attach_selected(EncoderChip::default(), select);
        }
        Ok(Self {
            chip,
            observer: None,
        })
    }

    /// Sets the word of the next encoder transfer.
    pub fn set_encoder(&mut self, word: SsiWord) {
        if let Some(encoder) = self.chip.part.spi[0].chip_mut::<EncoderChip>(0) {
            encoder.word = word;
        }
    }

    /// Number of encoder transfers.
    pub fn encoder_reads(&mut self) -> u64 {
        let encoder = self.chip.part.spi[0].chip_mut::<EncoderChip>(0);
        encoder.map_or(0, |encoder| encoder.reads)
    }
}

const NAME: &str = "actuator-board";

impl Board for ActuatorBoard {
    fn name(&self) -> &'static str {
        NAME
    }

    fn target_names(&self) -> Vec<&'static str> {
        vec![core::TARGET]
    }

    fn mcu(&mut self, target: usize) -> Option<&mut dyn Mcu> {
        (target == 0).then_some(&mut self.chip)
    }

    fn targets(&mut self) -> Vec<Target<'_>> {
        let observer = self.observer.clone();
        core::target(&mut self.chip, CORE_HZ, observer)
            .into_iter()
            .collect()
    }
}
