//! Configuration of the emulated core.

use std::num::{NonZeroU32, NonZeroU64};

use rigless::cpu;
use rigless::emulator::CoreSpec;
use rigless::machine::{Target, armv7m};
use rigless::mcu::{Mcu, Operate};

use super::resettable::Resettable;
use super::sleep::Sleep;
use super::spare_cores::CoreKind;
use crate::chip::{Chip, ChipH743, Remainder};
use crate::processor::SharedObserver;

/// Name of the chip.
pub(super) const TARGET: &str = "stm32f427";

/// A chip with a core of this kind as a target of the emulator.
pub(super) fn target<'a>(
    kind: CoreKind,
    mcu: &'a mut dyn Mcu,
    mut spec: CoreSpec,
    observer: Option<SharedObserver>,
    crc: Option<Remainder>,
    sleep: &Sleep,
) -> Target<'a> {
    spec.processor = Resettable::constructor(kind, spec.processor, observer, crc, sleep.clone());
    Target::new(kind.chip, mcu, spec)
}

/// The core of an STM32F427 as the emulator has it, with one instruction in each cycle of this
/// clock, and its vector table at the start of the flash or elsewhere.
pub(crate) fn spec(chip: &Chip, kind: &CoreKind) -> Option<CoreSpec> {
    let windows = cpu::armv7m::windows(Mcu::bus(chip));
    let core = core(armv7m::Variant::M4, chip, kind.clock_hz)?;
    let mut config = armv7m::Config::new(core, &windows);
    config.fpu = armv7m::Fpu::FpV4Sp;
    config.mpu_regions = regions(kind, armv7m::MpuRegions::Eight);
    config.vector_table = kind.vector_table;
    Some(config.spec())
}

/// The core of an STM32H743 as the emulator has it, with one instruction in each cycle of this
/// clock.
pub(crate) fn spec_h743(chip: &ChipH743, kind: &CoreKind) -> Option<CoreSpec> {
    let windows = cpu::armv7m::windows(Mcu::bus(chip));
    let core = core(armv7m::Variant::M7, chip, kind.clock_hz)?;
    let mut config = armv7m::Config::new(core, &windows);
    config.fpu = armv7m::Fpu::FpV5Dp;
    config.mpu_regions = regions(kind, armv7m::MpuRegions::Sixteen);
    config.caches = Some(CACHES);
    // The option bytes have it start there as delivered (RM0433, table 9); the ITCM is at zero.
    config.vector_table = Some(kind.vector_table.unwrap_or(FLASH));
    Some(config.spec())
}

/// The regions of the memory protection unit; none without it. A core without one ignores what a
/// program writes to its registers, as the emulator discards all translated code at each change of
/// its permissions.
fn regions(kind: &CoreKind, of_chip: armv7m::MpuRegions) -> armv7m::MpuRegions {
    if kind.protects_memory {
        of_chip
    } else {
        armv7m::MpuRegions::None
    }
}

/// Start of the flash.
const FLASH: u32 = 0x0800_0000;

/// What the cores of both chips have in common.
fn core(variant: armv7m::Variant, chip: &impl Operate, clock_hz: u64) -> Option<armv7m::Core> {
    Some(armv7m::Core {
        variant,
        clock_hz: NonZeroU64::new(clock_hz)?,
        interrupt_lines: NonZeroU32::new(chip.cpu().interrupt_lines.into())?,
        priority_bits: 4,
        refclk_divider: NonZeroU32::new(8)?,
        instructions_per_second: NonZeroU64::new(clock_hz)?,
        boot: "flash",
    })
}

/// The caches of the Cortex-M7, which the emulator identifies and does not model (PM0253, tables 77
/// and 81).
const CACHES: armv7m::Caches = armv7m::Caches {
    clidr: 0x0900_0003,
    ctr: 0x8303_c003,
    ccsidr: &[0xf00f_e019, 0xf01f_e009],
};
