//! CAN1 as slcan's bus: opened and closed without waiting, at every bit rate that slcan has.
//!
//! The controller leaves the bus, as RM0090 section 32.4.1 has it, when the frame that is on its way has ended; what it
//! is to do then is kept until it is ready. After bus-off it comes back by itself, 128 times 11 recessive bits later.

use canopen::{
    CanFrame,
    slcan::{Bus, flags},
};
use heapless::Deque;
use stm32f4xx_hal::pac::CAN1;

use crate::board::can_frames;

/// Quanta of a bit: 1 + 16 + 3, sampled at 85 %; at 800 kbit/s 1 + 7 + 2, sampled at 80 %.
const SEGMENTS: (u8, u8) = (16, 3);
const SEGMENTS_AT_800: (u8, u8) = (7, 2);

/// The clock of the controller, kHz.
const CLOCK_KHZ: u32 = 40_000;

/// Without a wish of the client: as the actuators are set when they are new, kbit/s.
const USUAL: u16 = 1000;

/// Frames that may wait for a mailbox: what the line brings in 28 ms at its fastest.
const WAITING: usize = 256;

/// How the controller is to join the bus.
#[derive(Clone, Copy)]
struct Wish {
    kbit_s: u16,
    silent: bool,
}

/// The controller, and what waits for it.
pub struct CanBus {
    registers: CAN1,
    waiting: Deque<CanFrame, WAITING>,
    wish: Option<Wish>,
    latched: u8,
}

impl CanBus {
    /// Off the bus; it hears everything when it is opened.
    pub fn new(can: CAN1) -> Self {
        // After a reset it sleeps, and the reset value with which a write begins says so.
        can.mcr().write(|w| w.sleep().clear_bit().inrq().set_bit());
        // All 32 bits of one filter, none of which matters, into queue 0.
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
            waiting: Deque::new(),
            wish: None,
            latched: 0,
        }
    }

    /// Joins the bus if somebody wants to and the controller is ready; called each millisecond.
    pub fn proceed(&mut self) {
        let can = &self.registers;
        if !can.msr().read().inak().bit() {
            self.note_arbitration();
            return;
        }
        let Some(Wish { kbit_s, silent }) = self.wish.take() else {
            return;
        };
        let (before, after) = if kbit_s == 800 {
            SEGMENTS_AT_800
        } else {
            SEGMENTS
        };
        let quanta = 1 + u32::from(before) + u32::from(after);
        let divider = CLOCK_KHZ / (quanta * u32::from(kbit_s).max(1));
        // SAFETY: the fields hold one less than these numbers; the greatest divider, of 10 kbit/s, is 200.
        can.btr().write(|w| unsafe {
            w.brp().bits((divider as u16).wrapping_sub(1));
            w.ts1().bits(before - 1).ts2().bits(after - 1).sjw().bits(1);
            w.silm().bit(silent)
        });
        // Comes back from bus-off by itself; sends in order; keeps what it has when a queue is full. It joins after
        // 11 recessive bits; nobody waits for them.
        can.mcr().write(|w| {
            w.sleep().clear_bit().inrq().clear_bit();
            w.abom().set_bit().txfp().set_bit().rflm().set_bit()
        });
        defmt::info!("on the bus at {} kbit/s, silent {}", kbit_s, silent as u8);
    }

    /// The next frame that came in.
    pub fn receive(&mut self) -> Option<CanFrame> {
        let queue = self.registers.rfr(0);
        if queue.read().fovr().bit() {
            self.latched |= flags::OVERRUN;
            queue.write(|w| w.fovr().set_bit());
        }
        can_frames::take(&self.registers)
    }

    /// A frame that came in found no room.
    pub fn lost(&mut self) {
        self.latched |= flags::RECEIVE_FULL;
    }

    /// Mailboxes have become free.
    pub fn mailbox_is_free(&mut self) {
        self.note_arbitration();
        self.registers
            .tsr()
            .write(|w| w.rqcp0().set_bit().rqcp1().set_bit().rqcp2().set_bit());
        self.fill_mailboxes();
    }

    /// The controller met an error.
    pub fn note_error(&mut self) {
        let can = &self.registers;
        /// No error since this was written.
        const SEEN: u8 = 7;
        if !matches!(can.esr().read().lec().bits(), 0 | SEEN) {
            self.latched |= flags::BUS_ERROR;
        }
        // SAFETY: what software may write.
        can.esr().write(|w| unsafe { w.lec().bits(SEEN) });
        can.msr().write(|w| w.erri().set_bit());
    }

    fn note_arbitration(&mut self) {
        let status = self.registers.tsr().read();
        if status.alst0().bit() || status.alst1().bit() || status.alst2().bit() {
            self.latched |= flags::ARBITRATION_LOST;
        }
    }

    fn fill_mailboxes(&mut self) {
        let Self {
            registers, waiting, ..
        } = self;
        can_frames::fill(registers, waiting);
    }
}

impl Bus for CanBus {
    fn open(&mut self, kbit_s: Option<u16>, silent: bool) -> bool {
        let kbit_s = kbit_s.unwrap_or(USUAL);
        self.wish = Some(Wish { kbit_s, silent });
        self.latched = 0;
        self.proceed();
        true
    }

    fn close(&mut self) {
        self.wish = None;
        self.waiting.clear();
        let can = &self.registers;
        can.tsr()
            .write(|w| w.abrq0().set_bit().abrq1().set_bit().abrq2().set_bit());
        can.mcr().modify(|_, w| w.inrq().set_bit());
    }

    fn send(&mut self, frame: &CanFrame) -> bool {
        let taken = self.waiting.push_back(*frame).is_ok();
        self.fill_mailboxes();
        taken
    }

    fn flags(&mut self) -> u8 {
        let errors = self.registers.esr().read();
        let mut now = core::mem::take(&mut self.latched);
        if errors.ewgf().bit() {
            now |= flags::ERROR_WARNING;
        }
        if errors.epvf().bit() || errors.boff().bit() {
            now |= flags::ERROR_PASSIVE;
        }
        now
    }
}
