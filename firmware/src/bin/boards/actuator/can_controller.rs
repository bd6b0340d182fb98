//! CAN1 of the actuator board. No operation waits for the bus.
//!
//! Received frames are fetched by a separate interrupt. Frames to be transmitted wait in two
//! queues for one of the three mailboxes, which transmit in the order in which they are filled:
//! process data, which may be discarded, and all others, which go first.
//!
//! The controller joins a bus listening, without acknowledging or signalling errors (RM0090,
//! section 32.4.2, silent mode): a board that is set to another bit rate would destroy every frame.
//! It takes part once it has received a valid frame of any identifier, or after [`QUIET_MS`]
//! without traffic and errors. A frame that no other station acknowledges is valid too once its
//! transmitter is error-passive, after 16 attempts: two stations suffice.
//!
//! After bus-off it waits, for [`BACK_OFF_MS`] at first and twice as long after each further
//! bus-off without a frame transmitted or received in between, for [`LONGEST_BACK_OFF_MS`] at most;
//! then it recovers, in 128 times 11 recessive bits (RM0090, section 32.7.6), and listens again.

use canopen::CanFrame;
use firmware::application::BusState;
use heapless::spsc::Consumer;
use stm32f4xx_hal::pac::CAN1;

use super::{
    acceptance::{self, AcceptedIds},
    bus_status,
    canopen_task::TRANSMIT_QUEUE,
    timing::{CAN_HZ, PWM_HZ},
};
use crate::board::can_registers;

/// Time without traffic and errors after which a listening controller takes part.
const QUIET_MS: u32 = 10;

/// Time off the bus after the first bus-off, and the longest one.
const BACK_OFF_MS: u32 = 10;
const LONGEST_BACK_OFF_MS: u32 = 1_280;

/// Mailboxes of the controller.
const MAILBOXES: usize = 3;

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

/// The queues of the frames to be transmitted.
pub struct TransmitQueues {
    /// Process data.
    pub process_data: Consumer<'static, CanFrame, TRANSMIT_QUEUE>,
    /// All other frames.
    pub others: Consumer<'static, CanFrame, TRANSMIT_QUEUE>,
}

/// How the controller takes part in the bus.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Participation {
    /// It shall join the bus, once it is in initialisation mode.
    Joining { listens: bool },
    /// It receives and does not acknowledge.
    Listening,
    /// It takes part.
    Full,
    /// Bus-off.
    Off,
}

/// The controller without its receive FIFO.
pub struct CanController {
    registers: CAN1,
    queues: TransmitQueues,
    kbit_s: u16,
    participation: Participation,
    /// Number of the PWM period in which the quiet time, or the time off the bus, began.
    since: u32,
    /// Time off the bus at the next bus-off.
    back_off_ms: u32,
    /// Mailboxes that hold process data.
    holds_process_data: [bool; MAILBOXES],
}

/// The receive FIFO, for an interrupt of its own.
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
    /// Joins the bus with this bit rate, kbit/s, and receives the frames with these identifiers.
    pub fn new(
        can: CAN1,
        kbit_s: u16,
        accepted: &AcceptedIds,
        queues: TransmitQueues,
    ) -> (Self, CanReceiver) {
        // After a reset the controller is in sleep mode. It transmits in order, and discards new
        // frames when the FIFO is full.
        can.mcr().write(|w| {
            w.sleep().clear_bit().inrq().set_bit();
            w.txfp().set_bit().rflm().set_bit()
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
            queues,
            kbit_s,
            participation: Participation::Joining { listens: true },
            since: 0,
            back_off_ms: BACK_OFF_MS,
            holds_process_data: [false; MAILBOXES],
        };
        controller.update();
        (controller, receiver)
    }

    /// Changes to another bit rate, kbit/s; frames that are not transmitted yet are discarded.
    pub fn set_bit_rate(&mut self, kbit_s: u16) {
        while self.queues.others.dequeue().is_some() {}
        while self.queues.process_data.dequeue().is_some() {}
        (self.registers.tsr()).write(|w| w.abrq0().set_bit().abrq1().set_bit().abrq2().set_bit());
        self.kbit_s = kbit_s;
        self.back_off_ms = BACK_OFF_MS;
        self.join(true);
    }

    /// Requests initialisation mode, from which the controller joins the bus. It enters that mode
    /// at once or at the end of the frame that it transmits, unless its receive line is stuck.
    fn join(&mut self, listens: bool) {
        self.participation = Participation::Joining { listens };
        self.registers.mcr().modify(|_, w| w.inrq().set_bit());
        self.update();
    }

    /// Joins the bus, ends listening, and returns after bus-off, each when it is time: call this
    /// periodically. Returns whether the controller has gone bus-off since the last call.
    pub fn update(&mut self) -> bool {
        let is_off = self.registers.esr().read().boff().bit();
        match self.participation {
            Participation::Joining { listens } if self.registers.msr().read().inak().bit() => {
                self.set_timing(listens);
                self.note_errors();
                self.registers.mcr().modify(|_, w| w.inrq().clear_bit());
                // It joins the bus after 11 recessive bits.
                self.since = bus_status::period();
                self.participation = match listens {
                    true => Participation::Listening,
                    false => Participation::Full,
                };
            }
            Participation::Listening if !is_off => self.listen(),
            Participation::Full if is_off => {
                self.since = bus_status::period();
                self.participation = Participation::Off;
                return true;
            }
            Participation::Off if self.has_elapsed(self.back_off_ms) => {
                self.back_off_ms = (self.back_off_ms * 2).min(LONGEST_BACK_OFF_MS);
                self.join(true);
            }
            _ => {}
        }
        false
    }

    fn listen(&mut self) {
        match self.registers.esr().read().lec().bits() {
            NO_ERROR => {
                self.back_off_ms = BACK_OFF_MS;
                self.join(false);
            }
            // Since the last call there was nothing; also behind the recovery from bus-off.
            SET_BY_PROGRAM if self.has_elapsed(QUIET_MS) => self.join(false),
            SET_BY_PROGRAM => {}
            _ => {
                self.since = bus_status::period();
                self.note_errors();
            }
        }
    }

    /// Whether so many milliseconds have elapsed since the start of the time that runs.
    fn has_elapsed(&self, ms: u32) -> bool {
        let elapsed = bus_status::period().wrapping_sub(self.since) & (u32::MAX >> 1);
        elapsed >= ms * (PWM_HZ / 1000)
    }

    /// The next frame or error shows in `ESR.LEC`.
    fn note_errors(&mut self) {
        // SAFETY: a value of its three bits.
        (self.registers.esr()).write(|w| unsafe { w.lec().bits(SET_BY_PROGRAM) });
    }

    fn set_timing(&mut self, listens: bool) {
        let bit_rate = u32::from(self.kbit_s) * 1000;
        let prescaler = CAN_HZ.checked_div(QUANTA * bit_rate).unwrap_or(1) as u16;
        // SAFETY: the fields hold one less than these numbers.
        self.registers.btr().write(|w| unsafe {
            w.brp()
                .bits(prescaler.saturating_sub(1))
                .ts1()
                .bits(SEGMENT_1 - 1)
                .ts2()
                .bits(SEGMENT_2 - 1)
                .sjw()
                .bits(JUMP_WIDTH - 1)
                .silm()
                .bit(listens)
        });
    }

    /// Changes the identifiers of the frames that are received.
    pub fn set_accepted_ids(&mut self, accepted: &AcceptedIds) {
        acceptance::change(&self.registers, accepted);
    }

    /// Acknowledges the mailboxes that have become free; returns how many of their frames were
    /// transmitted.
    pub fn take_transmitted(&mut self) -> u32 {
        let status = self.registers.tsr();
        let sent = status.read();
        let count = [sent.txok0().bit(), sent.txok1().bit(), sent.txok2().bit()];
        status.write(|w| w.rqcp0().set_bit().rqcp1().set_bit().rqcp2().set_bit());
        let count = count.map(u32::from).iter().sum();
        if count > 0 {
            self.back_off_ms = BACK_OFF_MS;
        }
        count
    }

    /// Moves frames from the queues into the free mailboxes.
    pub fn fill_mailboxes(&mut self) {
        for (mailbox, holds) in (self.registers.tx_iter()).zip(&mut self.holds_process_data) {
            if mailbox.tir().read().txrq().bit() {
                continue;
            }
            let other = self.queues.others.dequeue();
            *holds = other.is_none();
            let Some(frame) = other.or_else(|| self.queues.process_data.dequeue()) else {
                return;
            };
            can_registers::request_transmission(mailbox, &frame);
        }
    }

    /// Discards the process data that waits, in the queue and in mailboxes; a frame on the bus is
    /// transmitted to its end. Returns the number of frames.
    pub fn discard_process_data(&mut self) -> u32 {
        let mut count = 0;
        while self.queues.process_data.dequeue().is_some() {
            count += 1;
        }
        let [first, second, third] = self.holds_process_data;
        let pending = self
            .registers
            .tx_iter()
            .map(|mailbox| mailbox.tir().read().txrq().bit());
        let aborted = pending.zip(self.holds_process_data);
        count += aborted
            .filter(|(is_pending, holds)| *is_pending && *holds)
            .count() as u32;
        (self.registers.tsr())
            .write(|w| w.abrq0().bit(first).abrq1().bit(second).abrq2().bit(third));
        count
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
}
