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

use crate::{actuator::can_filters, board::can_frames};

/// What 42 MHz are divided by for 14 quanta a bit: at 500 kbit/s twice what 1 Mbit/s takes.
fn prescaler(bit_rate_kbit_s: u16) -> u16 {
    if bit_rate_kbit_s == 500 { 6 } else { 3 }
}

/// Frames that may wait for a mailbox: a tick's worth of telemetry and answers.
const WAITING: usize = 16;

/// The controller, but for what came in.
pub struct Can {
    registers: CAN1,
    waiting: Deque<CanFrame, WAITING>,
    /// The bit rate to go on the bus with, once the controller has left it.
    wanted_kbit_s: Option<u16>,
}

/// What came in, for an interrupt of its own.
pub struct Receiver(CAN1);

impl Receiver {
    /// The next frame that came in.
    pub fn receive(&mut self) -> Option<CanFrame> {
        can_frames::take(&self.0)
    }

    /// Whether frames were lost since this was asked last, as nobody had fetched those before.
    pub fn take_overrun(&mut self) -> bool {
        let queue = self.0.rfr(0);
        let is_overrun = queue.read().fovr().bit();
        if is_overrun {
            queue.write(|w| w.fovr().set_bit());
        }
        is_overrun
    }
}

impl Can {
    /// Goes on the bus, of 1000 kbit/s or 500 kbit/s. Frames with these identifiers come in, remote ones where it says
    /// so.
    pub fn new(
        can: CAN1,
        bit_rate_kbit_s: u16,
        identifiers: impl Iterator<Item = (Id, bool)>,
    ) -> (Self, Receiver) {
        // After a reset it sleeps. It comes back from bus-off by itself; sends in order; keeps what it has when a queue
        // is full.
        can.mcr().write(|w| {
            w.sleep().clear_bit().inrq().set_bit();
            w.abom().set_bit().txfp().set_bit().rflm().set_bit()
        });
        can_filters::set_up(&can, identifiers);
        can.ier().write(|w| {
            w.fmpie0().enabled().tmeie().enabled();
            w.bofie().enabled().epvie().enabled().errie().enabled()
        });
        // SAFETY: the receiver touches the registers of receive queue 0, and nobody else does.
        let receiver = Receiver(unsafe { CAN1::steal() });
        let mut can = Self {
            registers: can,
            waiting: Deque::new(),
            wanted_kbit_s: Some(bit_rate_kbit_s),
        };
        can.proceed();
        (can, receiver)
    }

    /// Goes over to another bit rate, of 1000 kbit/s or 500 kbit/s; what was to be sent is forgotten.
    pub fn set_bit_rate(&mut self, kbit_s: u16) {
        self.waiting.clear();
        (self.registers.tsr()).write(|w| w.abrq0().set_bit().abrq1().set_bit().abrq2().set_bit());
        self.registers.mcr().modify(|_, w| w.inrq().set_bit());
        self.wanted_kbit_s = Some(kbit_s);
        self.proceed();
    }

    /// Goes on the bus, if that is wanted and the controller has left it: it does so at once, or at the end of the frame
    /// that it sends, unless its receive line is stuck. Nobody waits for it; call this again and again. It joins after
    /// 11 recessive bits.
    #[inline(never)]
    pub fn proceed(&mut self) {
        if self.registers.msr().read().inak().bit()
            && let Some(kbit_s) = self.wanted_kbit_s.take()
        {
            set_timing(&self.registers, kbit_s);
            self.registers.mcr().modify(|_, w| w.inrq().clear_bit());
        }
    }

    /// Lets frames with other identifiers in.
    pub fn set_filters(&mut self, identifiers: impl Iterator<Item = (Id, bool)>) {
        can_filters::change(&self.registers, identifiers);
    }

    /// Whether no frame waits for a mailbox.
    pub fn is_idle(&self) -> bool {
        self.waiting.is_empty()
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
