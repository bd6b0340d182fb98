//! CAN1 with a queue towards the bus: nobody waits for it.
//!
//! A frame that came in is taken out of the controller at once, by an interrupt. What is to be sent
//! waits in a queue until one of the three mailboxes is free; mailboxes go out in the order in which
//! they were filled. After bus-off the controller comes back by itself, 128 times 11 recessive bits
//! later (RM0090, section 32.7.6).

use canopen::CanFrame;
use firmware::{application::BusState, parameters::BusSettings};
use heapless::Deque;
use stm32f4xx_hal::pac::CAN1;

use crate::can_frames;

/// What 42 MHz are divided by for 14 quanta a bit: at 500 kbit/s twice what 1 Mbit/s takes.
fn prescaler(settings: &BusSettings) -> u16 {
    if settings.bit_rate_kbit_s == 500 {
        6
    } else {
        3
    }
}

/// Standard data frames whose identifier agrees with `id` in the bits of `mask`.
#[derive(Clone, Copy)]
pub struct Filter {
    pub id: u16,
    pub mask: u16,
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
    /// Joins the bus. Frames that pass one of at most 14 filters, CAN1's share, come in.
    pub fn new(can: CAN1, settings: &BusSettings, filters: &[Filter]) -> Self {
        // After a reset it sleeps, and the reset value with which a write begins says so.
        can.mcr().write(|w| w.sleep().clear_bit().inrq().set_bit());
        // It answers at once, unless its receive line is stuck: then the board goes on without a bus.
        let _ = (0..ANSWERS_WITHIN).find(|_| can.msr().read().inak().bit());
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
        // 1 + 11 + 2 quanta: sampled at 85.7 %, resynchronised by up to two of them.
        // SAFETY: the fields hold one less than these numbers.
        can.btr().write(|w| unsafe {
            w.brp()
                .bits(prescaler(settings) - 1)
                .ts1()
                .bits(11 - 1)
                .ts2()
                .bits(2 - 1)
                .sjw()
                .bits(2 - 1)
        });
        accept(&can, filters);
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
        let Self { registers, waiting } = self;
        for mailbox in registers.tx_iter() {
            if mailbox.tir().read().txrq().bit() {
                continue;
            }
            let Some(frame) = waiting.pop_front() else {
                return;
            };
            can_frames::load(mailbox, &frame);
        }
    }
}

/// One bank of 32 bits with a mask for each filter, all into queue 0.
fn accept(can: &CAN1, filters: &[Filter]) {
    can.fmr().modify(|_, w| w.finit().set_bit());
    let mut banks = 0u32;
    for (bank, filter) in can.fb_iter().zip(filters) {
        banks = banks << 1 | 1;
        // Bits 1 and 2 are RTR and IDE: both must be clear.
        // SAFETY: any bits make a filter.
        bank.fr1()
            .write(|w| unsafe { w.bits(u32::from(filter.id) << 21) });
        bank.fr2()
            .write(|w| unsafe { w.bits(u32::from(filter.mask) << 21 | 0b110) });
    }
    // SAFETY: one bit for each bank.
    unsafe {
        can.fm1r().write(|w| w.bits(0));
        can.ffa1r().write(|w| w.bits(0));
        can.fs1r().write(|w| w.bits(banks));
        can.fa1r().write(|w| w.bits(banks));
    }
    can.fmr().modify(|_, w| w.finit().clear_bit());
}
