//! CAN1 with a queue towards the bus: nobody waits for it.
//!
//! A frame that came in is taken out of the controller at once, by an interrupt. What is to be sent
//! waits in a queue until one of the three mailboxes is free; mailboxes go out in the order in which
//! they were filled. After bus-off the controller comes back by itself, 128 times 11 recessive bits
//! later (RM0090, section 32.7.6).

use canopen::CanFrame;
use embedded_can::Id;
use firmware::application::BusState;
use heapless::Deque;
use stm32f4xx_hal::pac::CAN1;

use crate::{can_filters, can_frames};

/// What 42 MHz are divided by for 14 quanta a bit: at 500 kbit/s twice what 1 Mbit/s takes.
fn prescaler(bit_rate_kbit_s: u16) -> u16 {
    if bit_rate_kbit_s == 500 { 6 } else { 3 }
}

/// Reads of the status register until initialisation is given up: some milliseconds.
const ANSWERS_WITHIN: u32 = 100_000;

/// Frames that may wait for a mailbox: a tick's worth of telemetry and answers.
const WAITING: usize = 16;

/// The controller.
pub struct Can {
    registers: CAN1,
    waiting: Deque<CanFrame, WAITING>,
}

impl Can {
    /// Joins the bus, of 1000 kbit/s or 500 kbit/s. Frames with these identifiers come in, remote ones where it says
    /// so.
    pub fn new(
        can: CAN1,
        bit_rate_kbit_s: u16,
        identifiers: impl Iterator<Item = (Id, bool)>,
    ) -> Self {
        // After a reset it sleeps, and the reset value with which a write begins says so.
        can.mcr().write(|w| w.sleep().clear_bit().inrq().set_bit());
        await_initialisation(&can);
        // Comes back from bus-off by itself; sends in order; keeps what it has when a queue is full.
        can.mcr().write(|w| {
            w.sleep()
                .clear_bit()
                .inrq()
                .set_bit()
                .abom()
                .set_bit()
                .txfp()
                .set_bit()
                .rflm()
                .set_bit()
        });
        set_timing(&can, bit_rate_kbit_s);
        can_filters::let_in(&can, identifiers);
        can.ier().write(|w| {
            w.fmpie0().enabled().tmeie().enabled();
            w.bofie().enabled().epvie().enabled().errie().enabled()
        });
        // It joins after 11 recessive bits; nobody waits for them.
        can.mcr().modify(|_, w| w.inrq().clear_bit());
        Self {
            registers: can,
            waiting: Deque::new(),
        }
    }

    /// Goes over to another bit rate, of 1000 kbit/s or 500 kbit/s.
    pub fn set_bit_rate(&mut self, kbit_s: u16) {
        self.registers.mcr().modify(|_, w| w.inrq().set_bit());
        await_initialisation(&self.registers);
        set_timing(&self.registers, kbit_s);
        self.registers.mcr().modify(|_, w| w.inrq().clear_bit());
    }

    /// Lets frames with other identifiers in.
    pub fn set_filters(&mut self, identifiers: impl Iterator<Item = (Id, bool)>) {
        can_filters::let_in(&self.registers, identifiers);
    }

    /// Whether a frame was lost since this was asked last, as nobody had fetched those before.
    pub fn take_overrun(&mut self) -> bool {
        let queue = self.registers.rfr(0);
        let is_overrun = queue.read().fovr().bit();
        if is_overrun {
            queue.write(|w| w.fovr().set_bit());
        }
        is_overrun
    }

    /// Whether [`Can::send`] would take a frame.
    pub fn has_room(&self) -> bool {
        !self.waiting.is_full()
    }

    /// The next frame that came in.
    pub fn receive(&mut self) -> Option<CanFrame> {
        can_frames::take(&self.registers)
    }

    /// Sends a frame as soon as a mailbox is free; whether it could be taken.
    pub fn send(&mut self, frame: CanFrame) -> bool {
        let taken = self.waiting.push_back(frame).is_ok();
        self.fill_mailboxes();
        taken
    }

    /// Mailboxes have become free.
    pub fn mailbox_is_free(&mut self) {
        self.registers
            .tsr()
            .write(|w| w.rqcp0().set_bit().rqcp1().set_bit().rqcp2().set_bit());
        self.fill_mailboxes();
    }

    /// What the controller may do at present; forgets what it interrupted for.
    pub fn state(&mut self) -> BusState {
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
        can_frames::fill(&self.registers, &mut self.waiting);
    }
}

/// It answers at once, or at the end of the frame that it sends, unless its receive line is stuck: then the board
/// goes on without a bus.
fn await_initialisation(can: &CAN1) {
    let _ = (0..ANSWERS_WITHIN).find(|_| can.msr().read().inak().bit());
}

/// 1 + 11 + 2 quanta: sampled at 85.7 %, resynchronised by up to two of them.
fn set_timing(can: &CAN1, bit_rate_kbit_s: u16) {
    // SAFETY: the fields hold one less than these numbers.
    can.btr().write(|w| unsafe {
        w.brp()
            .bits(prescaler(bit_rate_kbit_s) - 1)
            .ts1()
            .bits(11 - 1)
            .ts2()
            .bits(2 - 1)
            .sjw()
            .bits(2 - 1)
    });
}
