//! The STM32F427: the part of rigless with this crate's bus, CAN1, flash, CRC unit and window
//! watchdog.

use std::num::NonZeroU32;

use rigless::device::{Device, ErasedDevice, Level, RegisterFile, ResetCause};
use rigless::emulator::CoreSpec;
use rigless::mcu::{Mcu, Operate};
use rigless::soc::stm32f427::Stm32f427;
use rigless::soc::stm32f427::generated::tim1::Register as R;
use rigless::soc::stm32f427::generated::{dbg, pwr, rcc, rtc, usart6};
use rigless::soc::stm32f427::peripherals::usart::Usart;
use rigless::soc::{Bus, Error, Layout, Width, stm32f427};
use rigless::time::VirtualNanos;

use super::crc_unit::{CrcUnit, Remainder};
use super::window_watchdog::WindowWatchdog;
use super::{ActuatorChip, PwmTimer, bus, outputs};
use crate::board::CoreKind;
use crate::board::{CORE_HZ, EncoderChip, core};
use crate::can::{BxCan, Station, Transfer, Wire};
use crate::faults::FilterBit;
use crate::flash::{FlashTimes, Interface};
use crate::plant::{Bridge, Sensed};
use crate::serial::SerialPeer;

/// Supply of the chip, mV.
const RAIL_MV: u32 = 3300;

/// Indices of USART1 and USART3 among the serial ports.
pub(crate) const USART1: usize = 0;
pub(crate) const USART3: usize = 2;

/// The chip.
#[derive(Debug)]
pub struct Chip {
    /// Peripherals that rigless models.
    pub part: Stm32f427,
    /// The CAN controller.
    pub can: BxCan,
    /// The flash.
    pub flash: Interface,
    window_watchdog: WindowWatchdog,
    crc_unit: CrcUnit,
    can_slot: usize,
    window_watchdog_slot: usize,
    crc_slot: usize,
    flash_slot: usize,
    /// Level at the break input.
    break_level: Level,
}

/// OPTCR as `docs/hardware.md` requires it: brown-out reset level 3, sectors 0 and 1
/// write-protected (RM0090, section 3.9.10).
const OPTION_BYTES: u64 = 0x0ffc_aae1;

/// Copies registers between two buses with the same instances.
fn keep<L: Layout>(
    from: &Bus,
    to: &mut Bus,
    instance: &'static str,
    registers: impl IntoIterator<Item = L>,
) {
    let (Some(source), Some(sink)) = (from.slot_of(instance), to.slot_of(instance)) else {
        return;
    };
    for register in registers {
        let value = from.slots()[source].registers().get(register);
        to.slot_mut(sink).registers_mut().set(register, value);
    }
}

/// What a reset of the part keeps (RM0090, section 6.1).
fn copy_backup_domain(from: &Bus, to: &mut Bus) {
    keep(from, to, "RCC", [rcc::Register::Csr, rcc::Register::Bdcr]);
    keep(from, to, "PWR", [pwr::Register::Csr]);
    keep(from, to, "RTC", rtc::Register::ALL.iter().copied());
    keep(from, to, "DBG", dbg::Register::ALL.iter().copied());
}

/// The part of rigless with the board's clock, supply and reference.
fn new_part() -> Result<Stm32f427, Error> {
    let mut part = Stm32f427::new()?;
    part.rcc.attach_crystals(8_000_000, 0);
    part.set_supply(RAIL_MV);
    // With a reference of full scale the input codes of the plant are converted unchanged.
    part.adc[0].set_reference(u32::from(super::outputs::FULL_SCALE));
    Ok(part)
}

impl Chip {
    /// A chip after power-on, with 8 MHz at HSE, on its own CAN bus or on a shared one.
    ///
    /// # Errors
    /// An error of rigless if the description of the chip is inconsistent.
    pub fn try_new(wire: Option<Wire>, times: FlashTimes, seed: u64) -> Result<Self, Error> {
        let mut part = new_part()?;
        // Same instances in the same order: the part's assignment of slots to models remains valid.
        *part.bus_mut() = bus::builder()?.build()?;
        let can_slot = part.bus().slot("CAN1")?;
        let flash_slot = part.bus().slot("FLASH")?;
        let window_watchdog_slot = part.bus().slot("WWDG")?;
        let crc_slot = part.bus().slot("CRC")?;
        let mut flash = Interface::new(times, seed);
        if let Some(rail_mv) = NonZeroU32::new(RAIL_MV) {
            flash.set_supply(rail_mv);
        }
        let mut chip = Self {
            part,
            can: BxCan::new(wire),
            flash,
            window_watchdog: WindowWatchdog::default(),
            crc_unit: CrcUnit::default(),
            can_slot,
            window_watchdog_slot,
            crc_slot,
            flash_slot,
            break_level: Level::High,
        };
        let slot = chip.part.bus_mut().slot_mut(flash_slot);
        chip.flash.set_options(OPTION_BYTES, slot.registers_mut());
        chip.check()?;
        chip.drive_break(VirtualNanos(0), Level::High);
        Ok(chip)
    }

    /// Resets the part. It rebuilds its bus and copies from the old one what a reset preserves: it
    /// gets a stock bus with these values for that time, and then this crate's bus again.
    fn restart(&mut self, at: VirtualNanos, cause: ResetCause, mut stock: Bus, mut ours: Bus) {
        copy_backup_domain(self.part.bus(), &mut stock);
        let old = std::mem::replace(self.part.bus_mut(), stock);
        // The part has one watchdog: the other one sets the same flag.
        let cause = match cause {
            ResetCause::Model("WWDG") => ResetCause::Model("IWDG"),
            other => other,
        };
        self.part.reset(at, cause);
        copy_backup_domain(self.part.bus(), &mut ours);
        self.install_bus(ours, &old);
    }

    /// Power-on reset: preserves only the devices at the pins.
    fn power_up(&mut self, ours: Bus) {
        let Ok(fresh) = new_part() else {
            unreachable!("it was built before");
        };
        let mut before = std::mem::replace(&mut self.part, fresh);
        for (fresh, before) in self.part.spi.iter_mut().zip(&mut before.spi) {
            fresh.inherit(before);
        }
        for (fresh, before) in self.part.usart.iter_mut().zip(&mut before.usart) {
            fresh.inherit(before);
        }
        for (fresh, before) in self.part.adc.iter_mut().zip(&before.adc) {
            fresh.inherit(before);
        }
        self.install_bus(ours, before.bus());
    }

    /// Installs the bus without confusing events scheduled before with later ones.
    fn install_bus(&mut self, mut ours: Bus, before: &Bus) {
        let continued = ours.keep_added(before);
        debug_assert!(continued.is_ok());
        *self.part.bus_mut() = ours;
    }

    fn restart_own_models(&mut self, at: VirtualNanos) {
        let registers = self
            .part
            .bus_mut()
            .slot_mut(self.flash_slot)
            .registers_mut();
        self.flash.restart(registers);
        let (registers, mut context) = self.part.bus_mut().drive(at, self.can_slot);
        Device::reset(&mut self.window_watchdog);
        Device::reset(&mut self.crc_unit);
        Device::reset_line(&mut self.can, registers, &mut context);
        self.drive_break(at, self.break_level);
    }
}

/// Discards what the peer sends to a receiver that is off, as while the program transmits on the
/// one wire of the servo bus. rigless keeps it until the receiver is on; its model of the STM32H743
/// discards it.
fn lose_unheard(usart: &mut Usart, registers: &RegisterFile, now: VirtualNanos) {
    let control = registers.get(usart6::Register::Cr1);
    if usart6::cr1::UE.is_set(control) && usart6::cr1::RE.is_set(control) {
        return;
    }
    if let Some(peer) = usart.chip_mut::<SerialPeer>() {
        peer.lose_due(now);
    }
}

impl ActuatorChip for Chip {
    fn name(&self) -> &'static str {
        "stm32f427"
    }

    fn core_hz(&self) -> u64 {
        CORE_HZ
    }

    fn core(&self, kind: &CoreKind) -> Option<CoreSpec> {
        core::spec(self, kind)
    }

    fn ram(&self) -> &'static [(u64, u64)] {
        &[(0x2000_0000, 192 << 10), (0x1000_0000, 64 << 10)]
    }

    fn encoder(&mut self) -> Option<&mut EncoderChip> {
        self.part.spi[0].chip_mut(0)
    }

    fn servo_bus(&mut self) -> Option<&mut SerialPeer> {
        self.part.usart[USART1].chip_mut()
    }

    fn bridge(&mut self) -> Bridge {
        outputs::bridge([self.leg(1), self.leg(2)])
    }

    fn set_sensor_inputs(&mut self, sensed: &Sensed) {
        self.set_inputs(sensed);
    }

    fn drive_servo(&mut self, at: VirtualNanos, level: Level) {
        self.drive_pulse_input(at, level);
    }

    fn pwm_timer(&mut self, at: VirtualNanos) -> PwmTimer {
        let (timer, registers) = self.part.advanced_timer(0);
        PwmTimer {
            control: registers.get(R::Cr1),
            count: Device::peek(timer, R::Cnt, registers, at).unwrap_or(0),
            prescaler: registers.get(R::Psc),
            compare_4: registers.get(R::Ccr4),
        }
    }

    fn break_level(&self) -> Level {
        self.break_level
    }

    fn drive_break(&mut self, at: VirtualNanos, level: Level) {
        self.break_level = level;
        self.part
            .drive_advanced_timer(at, 0, |timer, registers, context| {
                timer.drive_break(level, registers, context);
            });
    }

    fn set_power(&mut self, at: VirtualNanos, is_on: bool) {
        let (_, mut context) = self.part.bus_mut().drive(at, self.flash_slot);
        if is_on {
            context.request_power(true);
        } else {
            self.flash.lose_power(&mut context);
        }
    }

    fn feed_watchdog(&mut self, at: VirtualNanos) {
        const KEY_REGISTER: u64 = 0x4000_3000;
        const RELOAD: u64 = 0xaaaa;
        let written = self.write(at, KEY_REGISTER, Width::W32, RELOAD);
        debug_assert!(written.is_ok(), "the register exists");
    }

    fn crc_remainder(&self) -> Option<Remainder> {
        Some(self.crc_unit.remainder.clone())
    }

    fn stalls_core(&self) -> bool {
        self.flash.stalls_core()
    }

    fn flash(&mut self) -> Option<&mut Interface> {
        Some(&mut self.flash)
    }

    fn wire(&mut self) -> Option<&mut Wire> {
        self.can.wire.as_mut()
    }

    fn flip_filter(&mut self, bit: FilterBit) {
        self.can.flip_filter(bit);
    }

    fn station(&mut self, now_ns: u64) -> (Option<Station>, Option<u64>) {
        (self.can.station(now_ns), self.can.offers_since_ns())
    }

    fn end_frame(&mut self, at: VirtualNanos) {
        let (registers, mut context) = self.part.bus_mut().drive(at, self.can_slot);
        self.can.proceed(registers, &mut context);
    }

    fn begin_frame(
        &mut self,
        at: VirtualNanos,
        (began_ns, ends_ns): (u64, u64),
        transfer: Transfer,
        index: usize,
    ) {
        let (registers, mut context) = self.part.bus_mut().drive(at, self.can_slot);
        self.can.begin(began_ns, ends_ns, transfer, index);
        self.can.proceed(registers, &mut context);
    }
}

impl Mcu for Chip {
    fn bus(&self) -> &Bus {
        self.part.bus()
    }

    fn bus_mut(&mut self) -> &mut Bus {
        self.part.bus_mut()
    }

    fn reset(&mut self, at: VirtualNanos, cause: ResetCause) {
        let build = || bus::builder().and_then(|builder| builder.build());
        let (Ok(stock), Ok(ours)) = (stm32f427::builder().build(), build()) else {
            unreachable!("both were built before");
        };
        if cause == ResetCause::PowerOn {
            self.power_up(ours);
        } else {
            self.restart(at, cause, stock, ours);
        }
        self.restart_own_models(at);
    }

    fn poll(&mut self, now: VirtualNanos) {
        let (registers, mut context) = self.part.bus_mut().drive(now, self.can_slot);
        Device::poll(&mut self.can, registers, &mut context);
        // Of the serial ports, those at which a board has a peer.
        if self.part.usart[USART3].attached() {
            self.part
                .drive_serial_port(now, USART3, |usart, registers, context| {
                    Device::poll(usart, registers, context);
                });
        }
        if self.part.usart[USART1].attached() {
            self.part
                .drive_serial_port(now, USART1, |usart, registers, context| {
                    lose_unheard(usart, registers, context.now());
                    Device::poll(usart, registers, context);
                });
        }
    }

    fn split(&mut self, slot: usize) -> (&mut Bus, Option<&mut dyn ErasedDevice>) {
        if slot == self.can_slot {
            (self.part.bus_mut(), Some(&mut self.can))
        } else if slot == self.flash_slot {
            (self.part.bus_mut(), Some(&mut self.flash))
        } else if slot == self.crc_slot {
            (self.part.bus_mut(), Some(&mut self.crc_unit))
        } else if slot == self.window_watchdog_slot {
            (self.part.bus_mut(), Some(&mut self.window_watchdog))
        } else {
            self.part.split(slot)
        }
    }
}
