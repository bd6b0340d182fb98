//! CAN1 of the actuator board.

use canopen::CanFrame;
use drivers::can::{AcceptedIds, Activity, BusState, CanPort, Mode};

use super::{acceptance::Acceptance, timing::CAN_HZ};
use crate::chip::{can_registers, pac::CAN1};

/// `ESR.LEC`: no error; and the value that only a program sets.
const NO_ERROR: u8 = 0;
const SET_BY_PROGRAM: u8 = 7;

/// Time quanta of a bit before and after the sample point, behind the first quantum: sampled at
/// 85.7 %.
const SEGMENT_1: u8 = 11;
const SEGMENT_2: u8 = 2;
/// Quanta by which a resynchronisation may change a bit.
const JUMP_WIDTH: u8 = 2;
const QUANTA: u32 = 1 + SEGMENT_1 as u32 + SEGMENT_2 as u32;
const _: () = assert!(CAN_HZ.is_multiple_of(QUANTA * 1_000_000));

/// The registers of CAN1.
pub struct Can1(CAN1);

impl Can1 {
    /// Leaves the bus, to receive the frames with these identifiers; returns the port, one for the
    /// interrupt of the reception, and the filter.
    pub fn new(can: CAN1, accepted: &AcceptedIds) -> (Self, Self, Acceptance) {
        // After a reset the controller is in sleep mode. It transmits in order, and discards new
        // frames when the FIFO is full.
        can.mcr().write(|w| {
            w.sleep().clear_bit().inrq().set_bit();
            w.txfp().set_bit().rflm().set_bit()
        });
        // SAFETY: the registers of the filter, which nothing else accesses.
        let acceptance = Acceptance::new(unsafe { CAN1::steal() }, accepted);
        can.ier().write(|w| {
            w.fmpie0().enabled().tmeie().enabled();
            w.bofie().enabled().epvie().enabled().errie().enabled()
        });
        // SAFETY: the interrupt of the reception calls `receive` and `take_overrun`, which access
        // the registers of FIFO 0 only, and no other task calls these two.
        let receiver = unsafe { CAN1::steal() };
        (Self(can), Self(receiver), acceptance)
    }

    /// The next frame or error shows in `ESR.LEC`.
    fn note_errors(&mut self) {
        // SAFETY: a value of its three bits.
        (self.0.esr()).write(|w| unsafe { w.lec().bits(SET_BY_PROGRAM) });
    }

    fn set_timing(&mut self, kbit_s: u16, mode: Mode) {
        let bit_rate = u32::from(kbit_s) * 1000;
        let prescaler = CAN_HZ.checked_div(QUANTA * bit_rate).unwrap_or(1) as u16;
        // SAFETY: the fields hold one less than these numbers.
        self.0.btr().write(|w| unsafe {
            w.brp()
                .bits(prescaler.saturating_sub(1))
                .ts1()
                .bits(SEGMENT_1 - 1)
                .ts2()
                .bits(SEGMENT_2 - 1)
                .sjw()
                .bits(JUMP_WIDTH - 1)
                .silm()
                .bit(mode != Mode::Full)
                .lbkm()
                .bit(mode == Mode::LoopBack)
        });
    }
}

impl CanPort for Can1 {
    const MAILBOXES: usize = 3;

    #[inline]
    fn is_free(&self, mailbox: usize) -> bool {
        !self.0.tx(mailbox).tir().read().txrq().bit()
    }

    #[inline]
    fn put(&mut self, mailbox: usize, frame: &CanFrame) {
        can_registers::request_transmission(self.0.tx(mailbox), frame);
    }

    fn abort(&mut self, mailboxes: u32) {
        let [first, second, third] = [0, 1, 2].map(|mailbox| mailboxes >> mailbox & 1 != 0);
        (self.0.tsr()).write(|w| w.abrq0().bit(first).abrq1().bit(second).abrq2().bit(third));
    }

    fn take_transmitted(&mut self) -> u32 {
        let status = self.0.tsr();
        let sent = status.read();
        status.write(|w| w.rqcp0().set_bit().rqcp1().set_bit().rqcp2().set_bit());
        u32::from(sent.txok0().bit())
            + u32::from(sent.txok1().bit())
            + u32::from(sent.txok2().bit())
    }

    #[inline]
    fn receive(&mut self) -> Option<CanFrame> {
        let words = can_registers::received(&self.0)?;
        can_registers::release(&self.0);
        Some(can_registers::frame(&words))
    }

    #[inline]
    fn take_overrun(&mut self) -> bool {
        let fifo = self.0.rfr(0);
        let has_overrun = fifo.read().fovr().bit();
        if has_overrun {
            fifo.write(|w| w.fovr().set_bit());
        }
        has_overrun
    }

    fn leave(&mut self) {
        self.0.mcr().modify(|_, w| w.inrq().set_bit());
    }

    fn has_left(&self) -> bool {
        self.0.msr().read().inak().bit()
    }

    /// Listening is silent mode (RM0090, section 32.4.2), and loop back is silent too.
    fn join(&mut self, kbit_s: u16, mode: Mode) {
        self.set_timing(kbit_s, mode);
        self.note_errors();
        self.0.mcr().modify(|_, w| w.inrq().clear_bit());
    }

    fn is_off(&mut self) -> bool {
        self.0.esr().read().boff().bit()
    }

    fn take_activity(&mut self) -> Activity {
        match self.0.esr().read().lec().bits() {
            NO_ERROR => Activity::Frame,
            SET_BY_PROGRAM => Activity::None,
            _ => {
                self.note_errors();
                Activity::Error
            }
        }
    }

    fn take_state(&mut self) -> BusState {
        self.0.msr().write(|w| w.erri().set_bit());
        let errors = self.0.esr().read();
        if errors.boff().bit() {
            BusState::Off
        } else if errors.epvf().bit() {
            BusState::Passive
        } else {
            BusState::Active
        }
    }
}
