//! CAN1 of the communication board: opened and closed without waiting, at all bit rates of slcan.
//!
//! The controller leaves the bus at the end of the frame that it transmits (RM0090, section
//! 32.4.1); how to join the bus again is stored until then. After bus-off it recovers
//! automatically, after 128 times 11 recessive bits.

use canopen::{
    CanFrame,
    slcan::{Bus, flags},
};
use heapless::Deque;

use crate::chip::{can_registers, pac::CAN1};

/// Time quanta of a bit before and after the sample point, after the first quantum: 1 + 16 + 3,
/// sampled at 85 %; at 800 kbit/s 1 + 7 + 2, sampled at 80 %.
const SEGMENTS: (u8, u8) = (16, 3);
const SEGMENTS_AT_800: (u8, u8) = (7, 2);

/// Clock of the controller, kHz.
const CLOCK_KHZ: u32 = 40_000;

/// Bit rate unless the client sets one: the default of the actuators, kbit/s.
const DEFAULT_KBIT_S: u16 = 1000;

/// Frames that can wait for a mailbox: 28 ms of the serial line at its maximum.
const QUEUE_LENGTH: usize = 256;

/// Options with which to join the bus.
#[derive(Clone, Copy)]
struct BusOptions {
    kbit_s: u16,
    is_silent: bool,
}

/// The controller and its transmit queue.
pub struct CanController {
    registers: CAN1,
    queue: Deque<CanFrame, QUEUE_LENGTH>,
    /// Set while the controller has still to join the bus.
    pending: Option<BusOptions>,
    /// Status flags of slcan since the last query.
    latched_flags: u8,
}

impl CanController {
    /// Off the bus. Once it is opened, it receives all frames.
    pub fn new(can: CAN1) -> Self {
        // After a reset the controller is in sleep mode, in the register's reset value too.
        can.mcr().write(|w| w.sleep().clear_bit().inrq().set_bit());
        // One filter with a mask of zeros: all frames go to FIFO 0.
        can.fmr().modify(|_, w| w.finit().set_bit());
        if let Some(bank) = can.fb_iter().next() {
            // SAFETY: any bits make a filter.
            bank.fr1().write(|w| unsafe { w.bits(0) });
            // SAFETY: as above.
            bank.fr2().write(|w| unsafe { w.bits(0) });
        }
        // SAFETY: one bit for each bank.
        unsafe {
            can.fm1r().write(|w| w.bits(0));
            can.ffa1r().write(|w| w.bits(0));
            can.fs1r().write(|w| w.bits(1));
            can.fa1r().write(|w| w.bits(1));
        }
        can.fmr().modify(|_, w| w.finit().clear_bit());
        can.ier().write(|w| {
            w.fmpie0().enabled().tmeie().enabled();
            w.lecie().enabled().errie().enabled()
        });
        Self {
            registers: can,
            queue: Deque::new(),
            pending: None,
            latched_flags: 0,
        }
    }

    /// Joins the bus if that is pending and the controller is in initialisation mode; called each
    /// millisecond.
    pub fn join_bus_if_pending(&mut self) {
        let can = &self.registers;
        if !can.msr().read().inak().bit() {
            self.record_lost_arbitration();
            return;
        }
        let Some(BusOptions { kbit_s, is_silent }) = self.pending.take() else {
            return;
        };
        let (before, after) = if kbit_s == 800 {
            SEGMENTS_AT_800
        } else {
            SEGMENTS
        };
        let quanta = 1 + u32::from(before) + u32::from(after);
        let divider = CLOCK_KHZ / (quanta * u32::from(kbit_s).max(1));
        // SAFETY: the fields hold one less than these numbers; the largest divider, at 10 kbit/s,
        // is 200.
        can.btr().write(|w| unsafe {
            w.brp().bits((divider as u16).wrapping_sub(1));
            w.ts1().bits(before - 1).ts2().bits(after - 1).sjw().bits(1);
            w.silm().bit(is_silent)
        });
        // The controller recovers from bus-off automatically, transmits in order, and discards new
        // frames when the FIFO is full. It joins the bus after 11 recessive bits.
        can.mcr().write(|w| {
            w.sleep().clear_bit().inrq().clear_bit();
            w.abom().set_bit().txfp().set_bit().rflm().set_bit()
        });
        defmt::info!(
            "on the bus at {} kbit/s, silent {}",
            kbit_s,
            is_silent as u8
        );
    }

    /// The next received frame.
    pub fn receive(&mut self) -> Option<CanFrame> {
        let fifo = self.registers.rfr(0);
        if fifo.read().fovr().bit() {
            self.latched_flags |= flags::OVERRUN;
            fifo.write(|w| w.fovr().set_bit());
        }
        let words = can_registers::received(&self.registers)?;
        can_registers::release(&self.registers);
        Some(can_registers::frame(&words))
    }

    /// Records that a received frame is lost because the queue is full.
    pub fn record_lost_frame(&mut self) {
        self.latched_flags |= flags::RECEIVE_FULL;
    }

    /// Handles the interrupt of a free mailbox.
    pub fn on_mailbox_free(&mut self) {
        self.record_lost_arbitration();
        self.registers
            .tsr()
            .write(|w| w.rqcp0().set_bit().rqcp1().set_bit().rqcp2().set_bit());
        self.fill_mailboxes();
    }

    /// Handles the interrupt of an error.
    pub fn on_error(&mut self) {
        let can = &self.registers;
        /// Error code that software writes to detect the next error.
        const NO_NEW_ERROR: u8 = 7;
        if !matches!(can.esr().read().lec().bits(), 0 | NO_NEW_ERROR) {
            self.latched_flags |= flags::BUS_ERROR;
        }
        // SAFETY: software may write this code.
        can.esr().write(|w| unsafe { w.lec().bits(NO_NEW_ERROR) });
        can.msr().write(|w| w.erri().set_bit());
    }

    fn record_lost_arbitration(&mut self) {
        let status = self.registers.tsr().read();
        if status.alst0().bit() || status.alst1().bit() || status.alst2().bit() {
            self.latched_flags |= flags::ARBITRATION_LOST;
        }
    }

    fn fill_mailboxes(&mut self) {
        let Self {
            registers, queue, ..
        } = self;
        for mailbox in registers.tx_iter() {
            if mailbox.tir().read().txrq().bit() {
                continue;
            }
            let Some(frame) = queue.pop_front() else {
                return;
            };
            can_registers::request_transmission(mailbox, &frame);
        }
    }
}

impl Bus for CanController {
    fn open(&mut self, kbit_s: Option<u16>, is_silent: bool) -> bool {
        let kbit_s = kbit_s.unwrap_or(DEFAULT_KBIT_S);
        self.pending = Some(BusOptions { kbit_s, is_silent });
        self.latched_flags = 0;
        self.join_bus_if_pending();
        true
    }

    fn close(&mut self) {
        self.pending = None;
        self.queue.clear();
        let can = &self.registers;
        can.tsr()
            .write(|w| w.abrq0().set_bit().abrq1().set_bit().abrq2().set_bit());
        can.mcr().modify(|_, w| w.inrq().set_bit());
    }

    fn send(&mut self, frame: &CanFrame) -> bool {
        let is_queued = self.queue.push_back(*frame).is_ok();
        self.fill_mailboxes();
        is_queued
    }

    fn flags(&mut self) -> u8 {
        let errors = self.registers.esr().read();
        let mut status = core::mem::take(&mut self.latched_flags);
        if errors.ewgf().bit() {
            status |= flags::ERROR_WARNING;
        }
        if errors.epvf().bit() || errors.boff().bit() {
            status |= flags::ERROR_PASSIVE;
        }
        status
    }
}
