//! The board: the chip with the encoder on its bus, and the core that runs it.

mod encoder_chip;

use std::num::{NonZeroU32, NonZeroU64};

use rigless::cpu;
use rigless::device::Level;
use rigless::machine::{Board, Target, armv7m};
use rigless::mcu::{Mcu, Operate};
use rigless::snapshot::Store;
use rigless::soc::Error;
use rigless::soc::stm32f427::peripherals::gpio::Pin;
use rigless::soc::stm32f427::peripherals::spi::Select;

use self::encoder_chip::EncoderChip;
use crate::can::Wire;
use crate::chip::Chip;
use crate::flash::FlashTimes;
use crate::rig::SsiWord;

/// Clock of the core, Hz.
pub const CORE_HZ: u64 = 168_000_000;

/// The actuator management board.
#[derive(Debug)]
pub struct ActuatorBoard {
    /// The chip.
    pub chip: Chip,
}

// A run starts from power-on: there is no snapshot to take.
impl Store for ActuatorBoard {}

/// The pin that selects the encoder: PA4.
const SELECT_PIN: u8 = 4;

impl ActuatorBoard {
    /// A board after power-on.
    ///
    /// # Errors
    /// That of rigless, where the description of the chip does not hold together.
    pub fn try_new(wire: Wire, times: FlashTimes, seed: u64) -> Result<Self, Error> {
        let mut chip = Chip::try_new(wire, times, seed)?;
        if let Some(pin) = Pin::new(SELECT_PIN) {
            let select = Select {
                port: "GPIOA",
                pin,
                active: Level::Low,
            };
            chip.part.spi[0].attach_selected(EncoderChip::default(), select);
        }
        Ok(Self { chip })
    }

    /// What the next transfer from the encoder reads.
    pub fn set_encoder(&mut self, word: SsiWord) {
        if let Some(encoder) = self.chip.part.spi[0].chip_mut::<EncoderChip>(0) {
            encoder.word = word;
        }
    }

    /// Transfers from the encoder so far.
    pub fn encoder_reads(&mut self) -> u64 {
        let encoder = self.chip.part.spi[0].chip_mut::<EncoderChip>(0);
        encoder.map_or(0, |encoder| encoder.reads)
    }

    /// The core: one instruction a cycle.
    fn core(&self) -> Option<armv7m::Core> {
        let lines = Operate::cpu(&self.chip).interrupt_lines;
        Some(armv7m::Core {
            variant: armv7m::Variant::M4,
            clock_hz: NonZeroU64::new(CORE_HZ)?,
            interrupt_lines: NonZeroU32::new(lines.into())?,
            priority_bits: 4,
            refclk_divider: NonZeroU32::new(8)?,
            instructions_per_second: NonZeroU64::new(CORE_HZ)?,
            boot: "flash",
        })
    }
}

const NAME: &str = "actuator-board";
const TARGET: &str = "stm32f427";

impl Board for ActuatorBoard {
    fn name(&self) -> &'static str {
        NAME
    }

    fn target_names(&self) -> Vec<&'static str> {
        vec![TARGET]
    }

    fn mcu(&mut self, target: usize) -> Option<&mut dyn Mcu> {
        (target == 0).then_some(&mut self.chip)
    }

    fn targets(&mut self) -> Vec<Target<'_>> {
        let windows = cpu::armv7m::windows(Mcu::bus(&self.chip));
        let core = self.core().map(|core| {
            core.spec_with_parts(&windows, armv7m::Fpu::FpV4Sp, armv7m::MpuRegions::Eight)
        });
        core.map(|core| Target::new(TARGET, &mut self.chip, core))
            .into_iter()
            .collect()
    }
}
