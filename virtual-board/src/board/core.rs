//! Configuration of the emulated core.

use std::num::{NonZeroU32, NonZeroU64};

use rigless::cpu;
use rigless::emulator::CoreSpec;
use rigless::machine::{Target, armv7m};
use rigless::mcu::{Mcu, Operate};

use super::resettable::Resettable;
use crate::chip::Chip;
use crate::processor::SharedObserver;

/// Name of the chip.
pub(super) const TARGET: &str = "stm32f427";

/// The chip as a target of the emulator, with one instruction in each cycle of this clock.
pub(super) fn target(
    chip: &mut Chip,
    clock_hz: u64,
    observer: Option<SharedObserver>,
) -> Option<Target<'_>> {
    let mut spec = spec(chip, clock_hz)?;
    spec.processor = Resettable::constructor(spec.processor, observer);
    Some(Target::new(TARGET, chip, spec))
}

/// The core as the emulator has it.
pub(super) fn spec(chip: &Chip, clock_hz: u64) -> Option<CoreSpec> {
    let windows = cpu::armv7m::windows(Mcu::bus(chip));
    let lines = Operate::cpu(chip).interrupt_lines;
    let core = armv7m::Core {
        variant: armv7m::Variant::M4,
        clock_hz: NonZeroU64::new(clock_hz)?,
        interrupt_lines: NonZeroU32::new(lines.into())?,
        priority_bits: 4,
        refclk_divider: NonZeroU32::new(8)?,
        instructions_per_second: NonZeroU64::new(clock_hz)?,
        boot: "flash",
    };
    Some(core.spec_with_parts(&windows, armv7m::Fpu::FpV4Sp, armv7m::MpuRegions::Eight))
}
