//! FDCAN1 of the actuator board, as a controller of classical CAN.
//!
//! Frames leave from one buffer: the controller transmits several in the order of their
//! identifiers, or from a FIFO whose frames cannot be cancelled (RM0433, chapter 56), and the queue
//! in front of it needs both. The interrupt of its end fills it again.

use canopen::CanFrame;
use drivers::can::{AcceptedIds, Activity, BusState, CanPort, Mode};

use super::{message_ram, timing::CAN_HZ};
use crate::chip::pac::FDCAN1;

/// `PSR.LEC`: no error; and the value after it was read, until the next frame or error.
const NO_ERROR: u8 = 0;
const NO_CHANGE: u8 = 7;

/// Time quanta of a bit before and after the sample point, behind the first quantum: sampled at
/// 85.7 %.
const SEGMENT_1: u8 = 11;
const SEGMENT_2: u8 = 2;
/// Quanta by which a resynchronisation may change a bit.
const JUMP_WIDTH: u8 = 2;
const QUANTA: u32 = 1 + SEGMENT_1 as u32 + SEGMENT_2 as u32;
const _: () = assert!(CAN_HZ.is_multiple_of(QUANTA * 1_000_000));
const _: () = assert!(AcceptedIds::MAXIMUM <= 2 * message_ram::FILTERS as usize);

/// The bit of the transmit buffer.
const BUFFER: u32 = 1;

/// Reject frames that no filter accepts.
const REJECT: u8 = 0b10;

/// The registers of FDCAN1.
pub struct Can1 {
    registers: FDCAN1,
    /// What the controller has detected; a read of its register clears it.
    activity: Activity,
}

/// The filter elements in the message RAM.
pub struct Acceptance(());

impl Acceptance {
    /// Makes these the identifiers of the frames that are received, while frames are received.
    pub fn set(&mut self, accepted: &AcceptedIds) {
        let ids = accepted.identifiers().map(|(id, _)| id);
        message_ram::set_filters(ids, accepted.has_masks());
    }
}

impl Can1 {
    /// Leaves the bus, to receive the frames with these identifiers; returns the port, one for the
    /// interrupt of the reception, and the filter.
    pub fn new(can: FDCAN1, accepted: &AcceptedIds) -> (Self, Self, Acceptance) {
        can.cccr().modify(|_, w| w.init().set_bit());
        while can.cccr().read().init().bit_is_clear() {}
        can.cccr().modify(|_, w| w.cce().set_bit());
        // SAFETY: the lists are in the message RAM, and their elements hold eight bytes.
        unsafe {
            can.sidfc().write(|w| {
                w.flssa().bits(message_ram::STANDARD_FILTERS);
                w.lss().bits(message_ram::FILTERS as u8)
            });
            can.xidfc().write(|w| {
                w.flesa().bits(message_ram::EXTENDED_FILTERS);
                w.lse().bits(message_ram::FILTERS as u8)
            });
            can.gfc()
                .write(|w| w.anfs().bits(REJECT).anfe().bits(REJECT));
            can.rxf0c().write(|w| {
                w.f0sa().bits(message_ram::RECEIVE_FIFO);
                w.f0s().bits(message_ram::RECEIVED as u8)
            });
            can.rxesc().write(|w| w.bits(0));
            can.txesc().write(|w| w.bits(0));
            can.txbc()
                .write(|w| w.tbsa().bits(message_ram::TRANSMIT).ndtb().bits(1));
        }
        let mut acceptance = Acceptance(());
        acceptance.set(accepted);
        // SAFETY: bits of existing buffers.
        unsafe {
            can.txbtie().write(|w| w.bits(BUFFER));
            can.txbcie().write(|w| w.bits(BUFFER));
        }
        can.ie()
            .write(|w| w.rf0ne().set_bit().tce().set_bit().tcfe().set_bit());
        can.ils().write(|w| w.tcl().set_bit().tcfl().set_bit());
        can.ile().write(|w| w.eint0().set_bit().eint1().set_bit());
        // SAFETY: the interrupt of the reception calls `receive` and `take_overrun`, which access
        // the registers of FIFO 0 and its flags only, and no other task calls these two.
        let receiver = unsafe { FDCAN1::steal() };
        (Self::of(can), Self::of(receiver), acceptance)
    }

    const fn of(registers: FDCAN1) -> Self {
        Self {
            registers,
            activity: Activity::None,
        }
    }

    /// Whether the controller is bus-off, and whether error-passive. The read clears the last
    /// error: it is kept.
    fn status(&mut self) -> (bool, bool) {
        let status = self.registers.psr().read();
        match status.lec().bits() {
            NO_CHANGE => {}
            NO_ERROR => self.activity = Activity::Frame,
            _ => self.activity = Activity::Error,
        }
        (status.bo().bit(), status.ep().bit())
    }

    fn set_timing(&mut self, kbit_s: u16) {
        let bit_rate = u32::from(kbit_s) * 1000;
        let prescaler = CAN_HZ.checked_div(QUANTA * bit_rate).unwrap_or(1) as u16;
        // SAFETY: the fields hold one less than these numbers.
        self.registers.nbtp().write(|w| unsafe {
            w.nbrp().bits(prescaler.saturating_sub(1));
            w.ntseg1().bits(SEGMENT_1 - 1).ntseg2().bits(SEGMENT_2 - 1);
            w.nsjw().bits(JUMP_WIDTH - 1)
        });
    }
}

impl CanPort for Can1 {
    const MAILBOXES: usize = 1;

    #[inline]
    fn is_free(&self, _: usize) -> bool {
        self.registers.txbrp().read().bits() & BUFFER == 0
    }

    #[inline]
    fn put(&mut self, _: usize, frame: &CanFrame) {
        message_ram::set_transmitted(frame);
        // SAFETY: the buffer is free and holds a frame.
        self.registers.txbar().write(|w| unsafe { w.bits(BUFFER) });
    }

    fn abort(&mut self, mailboxes: u32) {
        // SAFETY: a bit of an existing buffer.
        (self.registers.txbcr()).write(|w| unsafe { w.bits(mailboxes & BUFFER) });
    }

    fn take_transmitted(&mut self) -> u32 {
        let has_ended = self.registers.ir().read().tc().bit();
        self.registers
            .ir()
            .write(|w| w.tc().bit(has_ended).tcf().set_bit());
        has_ended.into()
    }

    #[inline]
    fn receive(&mut self) -> Option<CanFrame> {
        self.registers.ir().write(|w| w.rf0n().set_bit());
        let fifo = self.registers.rxf0s().read();
        if fifo.f0fl().bits() == 0 {
            return None;
        }
        let index = fifo.f0gi().bits();
        let frame = message_ram::received(index);
        // SAFETY: the index of the oldest frame.
        (self.registers.rxf0a()).write(|w| unsafe { w.f0ai().bits(index) });
        Some(frame)
    }

    #[inline]
    fn take_overrun(&mut self) -> bool {
        let has_overrun = self.registers.ir().read().rf0l().bit();
        if has_overrun {
            self.registers.ir().write(|w| w.rf0l().set_bit());
        }
        has_overrun
    }

    fn leave(&mut self) {
        self.registers.cccr().modify(|_, w| w.init().set_bit());
    }

    /// After bus-off the controller has left the bus by itself.
    fn has_left(&self) -> bool {
        self.registers.cccr().read().init().bit()
    }

    /// Listening is the bus monitoring mode. A pending frame is requested again:
    /// the change of the configuration clears the request, not the frame.
    fn join(&mut self, kbit_s: u16, mode: Mode) {
        let pending = self.registers.txbrp().read().bits();
        let is_looped = mode == Mode::LoopBack;
        self.registers.cccr().modify(|_, w| w.cce().set_bit());
        self.registers.cccr().modify(|_, w| {
            w.mon().bit(mode != Mode::Full).test().bit(is_looped);
            w.pxhd().set_bit()
        });
        if is_looped {
            self.registers.test().modify(|_, w| w.lbck().set_bit());
        }
        self.set_timing(kbit_s);
        self.status();
        self.activity = Activity::None;
        self.registers
            .cccr()
            .modify(|_, w| w.init().clear_bit().cce().clear_bit());
        // SAFETY: the buffer holds the frame.
        self.registers.txbar().write(|w| unsafe { w.bits(pending) });
    }

    fn is_off(&mut self) -> bool {
        self.status().0
    }

    fn take_activity(&mut self) -> Activity {
        let activity = self.activity;
        if activity == Activity::Error {
            self.activity = Activity::None;
        }
        activity
    }

    /// A state that has ended since the last call is reported too.
    fn take_state(&mut self) -> BusState {
        let flags = self.registers.ir().read();
        let (was_passive, was_off) = (flags.ep().bit(), flags.bo().bit());
        self.registers
            .ir()
            .write(|w| w.ep().bit(was_passive).bo().bit(was_off));
        let (is_off, is_passive) = self.status();
        if is_off || was_off {
            BusState::Off
        } else if is_passive || was_passive {
            BusState::Passive
        } else {
            BusState::Active
        }
    }
}
