//! The STM32H743: the part of rigless with this crate's FDCAN1.
//!
//! rigless has the registers of FDCAN1 and FDCAN2 without behaviour, and no message RAM. FDCAN1 is
//! a window of the bus here, which hands offsets instead of registers to its model: the vendor's
//! file describes some of its registers as read-only. It takes the place of the instance's slot, so
//! that its clock and its interrupts remain wired.
//!
//! Not modelled by rigless, and listed as gaps of a run: both watchdogs and the backup registers,
//! which store what is written to them.

use std::num::NonZeroU64;

use rigless::device::{Device, ErasedDevice, Level, ResetCause};
use rigless::emulator::CoreSpec;
use rigless::mcu::Mcu;
use rigless::soc::stm32h743::Stm32h743;
use rigless::soc::stm32h743::generated::tim1::Register as R;
use rigless::soc::stm32h743::peripherals::adc::Channel as Input;
use rigless::soc::stm32h743::peripherals::gpio::Pin;
use rigless::soc::stm32h743::peripherals::spi::Select;
use rigless::soc::stm32h743::peripherals::tim::{
    ADVANCED_TIMERS, BreakInput, BreakSource, Channel, TIMERS, Tim,
};
use rigless::soc::{Bus, Error, Window, stm32h743};
use rigless::time::VirtualNanos;

use super::ActuatorChip;
use super::outputs::{self, FULL_SCALE, Leg, PwmTimer};
use crate::board::CoreKind;
use crate::board::{EncoderChip, SELECT_PIN, core};
use crate::can::{FdCan, MESSAGE_RAM_BYTES, MessageRam, Station, Transfer, Wire};
use crate::faults::FilterBit;
use crate::flash::Interface;
use crate::plant::{Bridge, Sensed};
use crate::serial::SerialPeer;

/// Clock of the core, Hz.
const CORE_HZ: u64 = 336_000_000;

/// Supply of the chip, mV.
const RAIL_MV: u32 = 3300;

/// Index of USART1 among the serial ports.
const USART1: usize = 0;

/// Index of TIM4 among the general-purpose timers.
const TIM4: usize = 2;

/// FDCAN1 with both its interrupts, and the message RAM (RM0433, section 2.3 and table 147).
const CONTROLLER: (&str, u64, u64) = ("FDCAN1", 0x4000_a000, 0x400);
static LINES: [u16; 2] = [19, 21];
const MEMORY: (&str, u64) = ("FDCAN message RAM", 0x4000_ac00);

/// Converter channels of the pins PA3, PC3, PC0, PC2 and PB1.
mod input {
    pub const CURRENT: u8 = 15;
    pub const SUPPLY: u8 = 13;
    pub const LEG_A: u8 = 10;
    pub const LEG_B: u8 = 12;
    pub const TEMPERATURE: u8 = 5;
}

/// The chip.
#[derive(Debug)]
pub struct ChipH743 {
    /// Peripherals that rigless models.
    part: Stm32h743,
    can: FdCan,
    message_ram: MessageRam,
    can_slot: usize,
    memory_slot: usize,
    /// The slot of FDCAN1 that the window replaces.
    replaced: Bus,
    break_level: Level,
}

const fn bytes(count: u64) -> NonZeroU64 {
    match NonZeroU64::new(count) {
        Some(count) => count,
        None => panic!("a window has bytes"),
    }
}

/// A bus whose only slot is the window of FDCAN1.
fn controller_bus() -> Result<Bus, Error> {
    let (name, base, size) = CONTROLLER;
    let mut bus = Bus::builder(stm32h743::CPU, &[], []).build()?;
    bus.add_window(Window::new(name, base, bytes(size)).raising(&LINES))?;
    Ok(bus)
}

impl ChipH743 {
    /// A chip after power-on, with 8 MHz at HSE, on its own CAN bus or on a shared one.
    ///
    /// # Errors
    /// An error of rigless if the description of the chip is inconsistent.
    pub fn try_new(wire: Option<Wire>) -> Result<Self, Error> {
        let mut part = Stm32h743::new()?;
        part.rcc.attach_crystals(8_000_000, 0);
        part.set_supply(RAIL_MV);
        part.set_analog_supply(RAIL_MV);
        for adc in &mut part.adc {
            // With a reference of full scale the input codes of the plant are converted unchanged.
            adc.set_reference(u32::from(FULL_SCALE));
        }
        if let Some(pin) = Pin::new(SELECT_PIN) {
            let select = Select {
                port: "GPIOA",
                pin,
                active: Level::Low,
            };
            part.spi[0].attach_selected(EncoderChip::default(), select);
        }
        part.usart[USART1].attach(SerialPeer::default());
        let mut replaced = controller_bus()?;
        let can_slot = part.bus().slot(CONTROLLER.0)?;
        std::mem::swap(part.bus_mut().slot_mut(can_slot), replaced.slot_mut(0));
        let (name, base) = MEMORY;
        let window = Window::new(name, base, bytes(MESSAGE_RAM_BYTES));
        let memory_slot = part.bus_mut().add_window(window)?;
        let layout = |slot: usize| part.bus().slots()[slot].peripheral().registers;
        let message_ram = MessageRam::new(layout(memory_slot));
        let can = FdCan::new(wire, message_ram.clone(), layout(can_slot));
        let mut chip = Self {
            part,
            can,
            message_ram,
            can_slot,
            memory_slot,
            replaced,
            break_level: Level::High,
        };
        chip.drive_break(VirtualNanos(0), Level::High);
        Ok(chip)
    }

    /// The leg at the outputs of a channel of TIM1.
    fn leg(&mut self, number: u8) -> Leg {
        let (timer, registers) = self.part.advanced_timer(0);
        let Some(channel) = Channel::new(number) else {
            return Leg::Off;
        };
        if let Some(pulse) = timer.pulse(channel, registers) {
            return Leg::of_pulse(pulse.width.0);
        }
        Leg::of_levels(
            timer.output(channel, registers),
            timer.complementary_output(channel, registers),
        )
    }

    fn set_input(&mut self, converter: usize, channel: u8, code: u16) {
        if let Some(channel) = Input::new(channel) {
            self.part.adc[converter].set_input(channel, code.into());
        }
    }

    /// Swaps the slot of FDCAN1 with the one that its window replaces.
    fn swap_controller(&mut self) {
        let slot = self.part.bus_mut().slot_mut(self.can_slot);
        std::mem::swap(slot, self.replaced.slot_mut(0));
    }

    fn proceed(&mut self, at: VirtualNanos) {
        let (_, mut context) = self.part.bus_mut().drive(at, self.can_slot);
        self.can.proceed(&mut context);
    }
}

impl ActuatorChip for ChipH743 {
    fn name(&self) -> &'static str {
        "stm32h743"
    }

    fn core_hz(&self) -> u64 {
        CORE_HZ
    }

    fn core(&self, kind: &CoreKind) -> Option<CoreSpec> {
        core::spec_h743(self, kind)
    }

    fn ram(&self) -> &'static [(u64, u64)] {
        &[(0x2000_0000, 128 << 10), (0x2400_0000, 512 << 10)]
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

    /// Current and supply at ADC1, legs and temperature at ADC2.
    fn set_sensor_inputs(&mut self, sensed: &Sensed) {
        self.set_input(0, input::CURRENT, sensed.current.bits());
        self.set_input(0, input::SUPPLY, sensed.supply.bits());
        self.set_input(1, input::TEMPERATURE, sensed.temperature.bits());
        self.set_input(1, input::LEG_A, sensed.legs.a.bits());
        self.set_input(1, input::LEG_B, sensed.legs.b.bits());
    }

    fn drive_servo(&mut self, at: VirtualNanos, level: Level) {
        let Ok(slot) = self.part.bus().slot("TIM4") else {
            return;
        };
        // The part lends the timer or its bus, not both: the timer is out of it meanwhile.
        let mut timer = std::mem::replace(&mut self.part.tim[TIM4], Tim::new(TIMERS[TIM4]));
        let (registers, mut context) = self.part.bus_mut().drive(at, slot);
        if let Some(channel) = Channel::new(1) {
            timer.drive_input(channel, level, registers, &mut context);
        }
        self.part.tim[TIM4] = timer;
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
        let Ok(slot) = self.part.bus().slot("TIM1") else {
            return;
        };
        let placeholder = Tim::new(ADVANCED_TIMERS[0]);
        let mut timer = std::mem::replace(&mut self.part.advanced[0], placeholder);
        let (registers, mut context) = self.part.bus_mut().drive(at, slot);
        timer.drive_break(
            BreakInput::First,
            BreakSource::Pin,
            level,
            registers,
            &mut context,
        );
        self.part.advanced[0] = timer;
    }

    fn set_power(&mut self, at: VirtualNanos, is_on: bool) {
        let (_, mut context) = self.part.bus_mut().drive(at, self.can_slot);
        context.request_power(is_on);
    }

    /// The program runs from bank 1 and writes bank 2.
    fn stalls_core(&self) -> bool {
        false
    }

    fn flash(&mut self) -> Option<&mut Interface> {
        None
    }

    fn wire(&mut self) -> Option<&mut Wire> {
        self.can.wire.as_mut()
    }

    fn flip_filter(&mut self, bit: FilterBit) {
        self.can.flip_filter(bit);
    }

    fn station(&mut self, _: u64) -> (Option<Station>, Option<u64>) {
        (self.can.station(), self.can.offers_since_ns())
    }

    fn end_frame(&mut self, at: VirtualNanos) {
        self.proceed(at);
    }

    fn begin_frame(
        &mut self,
        at: VirtualNanos,
        (_, ends_ns): (u64, u64),
        transfer: Transfer,
        index: usize,
    ) {
        self.can.begin(ends_ns, transfer, index);
        self.proceed(at);
    }
}

impl Mcu for ChipH743 {
    fn bus(&self) -> &Bus {
        self.part.bus()
    }

    fn bus_mut(&mut self) -> &mut Bus {
        self.part.bus_mut()
    }

    /// The part compares its bus with a fresh one, and therefore gets its own slot back meanwhile.
    fn reset(&mut self, at: VirtualNanos, cause: ResetCause) {
        self.swap_controller();
        self.part.reset(at, cause);
        self.swap_controller();
        let (registers, mut context) = self.part.bus_mut().drive(at, self.can_slot);
        ErasedDevice::reset_line(&mut self.can, registers, &mut context);
        self.drive_break(at, self.break_level);
    }

    fn poll(&mut self, now: VirtualNanos) {
        let (registers, mut context) = self.part.bus_mut().drive(now, self.can_slot);
        ErasedDevice::poll(&mut self.can, registers, &mut context);
        // The serial ports.
        Mcu::poll(&mut self.part, now);
    }

    fn split(&mut self, slot: usize) -> (&mut Bus, Option<&mut dyn ErasedDevice>) {
        if slot == self.can_slot {
            (self.part.bus_mut(), Some(&mut self.can))
        } else if slot == self.memory_slot {
            (self.part.bus_mut(), Some(&mut self.message_ram))
        } else {
            self.part.split(slot)
        }
    }
}
