//! What a run needs of the chip of an actuator board.

use std::fmt::Debug;

use rigless::device::Level;
use rigless::emulator::CoreSpec;
use rigless::mcu::{Mcu, Operate};
use rigless::soc::Width;
use rigless::time::VirtualNanos;

use super::crc_unit::Remainder;
use super::outputs::PwmTimer;
use crate::board::CoreKind;
use crate::board::EncoderChip;
use crate::can::{Station, Transfer, Wire};
use crate::faults::FilterBit;
use crate::flash::Interface;
use crate::plant::{Bridge, Sensed};
use crate::serial::SerialPeer;

/// The chip of an actuator board: its pins, its CAN controller, its memory.
pub trait ActuatorChip: Mcu + Send + Debug {
    /// Its name.
    fn name(&self) -> &'static str;

    /// Clock of its core, Hz: one instruction in each cycle.
    fn core_hz(&self) -> u64;

    /// Its core, of this kind; `None` if its description is inconsistent.
    fn core(&self, kind: &CoreKind) -> Option<CoreSpec>;

    /// Address and size of its RAM, bytes.
    fn ram(&self) -> &'static [(u64, u64)];

    /// The encoder at its SPI.
    fn encoder(&mut self) -> Option<&mut EncoderChip>;

    /// The other end of the servo bus, at USART1; none on a board without one.
    fn servo_bus(&mut self) -> Option<&mut SerialPeer>;

    /// The state of the bridge, as TIM1 drives its pins.
    fn bridge(&mut self) -> Bridge;

    /// Sets the codes at the converter's inputs.
    fn set_sensor_inputs(&mut self, sensed: &Sensed);

    /// Drives the servo pulse input.
    fn drive_servo(&mut self, at: VirtualNanos, level: Level);

    /// The registers of TIM1.
    fn pwm_timer(&mut self, at: VirtualNanos) -> PwmTimer;

    /// Level at the break input.
    fn break_level(&self) -> Level;

    /// Drives the break input; low is a break.
    fn drive_break(&mut self, at: VirtualNanos, level: Level);

    /// Switches the supply.
    fn set_power(&mut self, at: VirtualNanos, is_on: bool);

    /// Reloads the counter of the independent watchdog from outside the program; it has none if it
    /// is not modelled.
    fn feed_watchdog(&mut self, _: VirtualNanos) {}

    /// What its CRC unit holds, if it is a model of this crate.
    fn crc_remainder(&self) -> Option<Remainder> {
        None
    }

    /// Whether its flash stalls the core.
    fn stalls_core(&self) -> bool;

    /// Its flash, if it is a model of this crate.
    fn flash(&mut self) -> Option<&mut Interface>;

    /// The bus of its CAN controller with its ports; `None` if it is shared.
    fn wire(&mut self) -> Option<&mut Wire>;

    /// Flips a bit of the acceptance filter of its CAN controller.
    fn flip_filter(&mut self, bit: FilterBit);

    /// Its CAN controller as a station of a shared bus, and the time since which it has had a frame
    /// to transmit, ns.
    fn station(&mut self, now_ns: u64) -> (Option<Station>, Option<u64>);

    /// Completes a frame on a shared bus whose time has elapsed, which updates the frame that the
    /// controller offers.
    fn end_frame(&mut self, at: VirtualNanos);

    /// Starts a frame that won the arbitration on a shared bus, from `began_ns` to `ends_ns`;
    /// `index` is the index of this controller among the stations.
    fn begin_frame(
        &mut self,
        at: VirtualNanos,
        times_ns: (u64, u64),
        transfer: Transfer,
        index: usize,
    );

    /// Reads a register without side effects, as a debugger does.
    fn peek_register(&mut self, at: VirtualNanos, address: u64) -> u64 {
        self.peek(at, address, Width::W32).unwrap_or(0)
    }
}
