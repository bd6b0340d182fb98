//! CAN1 of the actuator board. No operation waits for the bus.
//!
//! Received frames are fetched by a separate interrupt. Frames to be transmitted wait in a
//! queue for one of the three mailboxes, which transmit in the order in which they are filled.
//! After bus-off the controller recovers automatically, after 128 times 11 recessive bits (RM0090,
//! section 32.7.6).

use canopen::CanFrame;
use firmware::application::BusState;
use heapless::Deque;
use stm32f4xx_hal::pac::CAN1;

use super::{
    acceptance::{self, AcceptedIds},
    timing::CAN_HZ,
};
use crate::board::can_registers;

/// Frames that can wait for a mailbox: the others wait in the queue of the CANopen device, which
/// can still discard them.
const QUEUE_LENGTH: usize = 1;

/// Time quanta of a bit before and after the sample point, after the first quantum: sampled at
/// 85.7 %.
const SEGMENT_1: u8 = 11;
const SEGMENT_2: u8 = 2;
/// Quanta by which a resynchronisation may change a bit.
const JUMP_WIDTH: u8 = 2;
const QUANTA: u32 = 1 + SEGMENT_1 as u32 + SEGMENT_2 as u32;
const _: () = assert!(CAN_HZ.is_multiple_of(QUANTA * 1_000_000));

/// The controller without its receive FIFO.
pub struct CanController {
    registers: CAN1,
    queue: Deque<CanFrame, QUEUE_LENGTH>,
    /// Bit rate with which to join the bus once the controller is in initialisation mode.
    pending_kbit_s: Option<u16>,
}

/// The receive FIFO, for a separate interrupt.
pub struct CanReceiver(CAN1);

impl CanReceiver {
    /// The next received frame.
    pub fn receive(&mut self) -> Option<CanFrame> {
        can_registers::receive(&self.0)
    }

    /// Whether the FIFO has overrun since the last call.
    pub fn take_overrun(&mut self) -> bool {
        let fifo = self.0.rfr(0);
        let has_overrun = fifo.read().fovr().bit();
        if has_overrun {
            fifo.write(|w| w.fovr().set_bit());
        }
        has_overrun
    }
}

impl CanController {
    /// Joins the bus with 1000 kbit/s or 500 kbit/s, and receives the frames with these
    /// identifiers.
    pub fn new(can: CAN1, kbit_s: u16, accepted: &AcceptedIds) -> (Self, CanReceiver) {
        // After a reset the controller is in sleep mode. It recovers from bus-off automatically,
        // transmits in order, and discards new frames when the FIFO is full.
        can.mcr().write(|w| {
            w.sleep().clear_bit().inrq().set_bit();
            w.abom().set_bit().txfp().set_bit().rflm().set_bit()
        });
        acceptance::set_up(&can, accepted);
        can.ier().write(|w| {
            w.fmpie0().enabled().tmeie().enabled();
            w.bofie().enabled().epvie().enabled().errie().enabled()
        });
        // SAFETY: the receiver accesses the registers of FIFO 0 only, and it alone does.
        let receiver = CanReceiver(unsafe { CAN1::steal() });
        let mut controller = Self {
            registers: can,
            queue: Deque::new(),
            pending_kbit_s: Some(kbit_s),
        };
        controller.join_bus_if_pending();
        (controller, receiver)
    }

    /// Changes to a bit rate of 1000 kbit/s or 500 kbit/s; frames that are not transmitted yet are
    /// discarded.
    pub fn set_bit_rate(&mut self, kbit_s: u16) {
        self.queue.clear();
        (self.registers.tsr()).write(|w| w.abrq0().set_bit().abrq1().set_bit().abrq2().set_bit());
        self.registers.mcr().modify(|_, w| w.inrq().set_bit());
        self.pending_kbit_s = Some(kbit_s);
        self.join_bus_if_pending();
    }

    /// Joins the bus with the pending bit rate, if the controller is in initialisation mode. It
    /// enters that mode at once or at the end of the frame that it transmits, unless its receive
    /// line is stuck: call this periodically. It joins the bus after 11 recessive bits.
    pub fn join_bus_if_pending(&mut self) {
        if self.registers.msr().read().inak().bit()
            && let Some(kbit_s) = self.pending_kbit_s.take()
        {
            self.set_timing(kbit_s);
            self.registers.mcr().modify(|_, w| w.inrq().clear_bit());
        }
    }

    fn set_timing(&mut self, kbit_s: u16) {
        let bit_rate: u32 = if kbit_s == 500 { 500_000 } else { 1_000_000 };
        let prescaler = (CAN_HZ / (QUANTA * bit_rate)) as u16;
        // SAFETY: the fields hold one less than these numbers.
        self.registers.btr().write(|w| unsafe {
            w.brp()
                .bits(prescaler - 1)
                .ts1()
                .bits(SEGMENT_1 - 1)
                .ts2()
                .bits(SEGMENT_2 - 1)
                .sjw()
                .bits(JUMP_WIDTH - 1)
        });
    }

    /// Changes the identifiers of the frames that are received.
    pub fn set_accepted_ids(&mut self, accepted: &AcceptedIds) {
        acceptance::change(&self.registers, accepted);
    }

    /// Whether no frame waits for a mailbox.
    pub fn is_queue_empty(&self) -> bool {
        self.queue.is_empty()
    }

    /// Transmits a frame as soon as a mailbox is free. Call this only while the queue is empty.
    pub fn transmit(&mut self, frame: CanFrame) {
        // There is room: the queue is empty.
        let _ = self.queue.push_back(frame);
        self.fill_mailboxes();
    }

    /// Handles the interrupt of a free mailbox.
    pub fn on_mailbox_free(&mut self) {
        self.registers
            .tsr()
            .write(|w| w.rqcp0().set_bit().rqcp1().set_bit().rqcp2().set_bit());
        self.fill_mailboxes();
    }

    /// Present state of the controller; acknowledges its interrupt.
    pub fn take_state(&mut self) -> BusState {
        self.registers.msr().write(|w| w.erri().set_bit());
        let errors = self.registers.esr().read();
        if errors.boff().bit() {
            BusState::Off
        } else if errors.epvf().bit() {
            BusState::Passive
        } else {
            BusState::Active
        }
    }

    fn fill_mailboxes(&mut self) {
        can_registers::fill_mailboxes(&self.registers, &mut self.queue);
    }
}
