//! Hardware in memory: a timer, an SPI transfer, a CAN controller and a NOR flash.

use std::{cell::RefCell, collections::VecDeque, rc::Rc};

use canopen::CanFrame;
use drivers::{
    bridge::{Compare, PwmTimer},
    can::{Activity, BusState, CanPort, Mode},
    encoder::Transfer,
};
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};

/// A timer with a break input, and defects to seed.
#[derive(Debug)]
pub struct Timer {
    pub compare: Compare,
    pub are_on: bool,
    pub has_tripped: bool,
    /// The break input does nothing.
    pub has_dead_break: bool,
    /// Leg B follows the compare value of leg A.
    pub has_swapped_legs: bool,
    /// The outputs stay on.
    pub is_stuck_on: bool,
}

impl Timer {
    pub const fn new() -> Self {
        Self {
            compare: Compare {
                leg_a: 0,
                leg_b: 0,
                sample: 0,
            },
            are_on: false,
            has_tripped: false,
            has_dead_break: false,
            has_swapped_legs: false,
            is_stuck_on: false,
        }
    }

    /// A moment of over-current.
    pub fn trip(&mut self) {
        if !self.has_dead_break {
            self.has_tripped = true;
            self.are_on = false;
        }
    }
}

impl PwmTimer for Timer {
    fn set_compare(&mut self, compare: Compare) {
        self.compare = compare;
    }

    fn compare(&self) -> Compare {
        let Compare { leg_a, leg_b, .. } = self.compare;
        match self.has_swapped_legs {
            true => Compare {
                leg_a: leg_b,
                leg_b: leg_a,
                ..self.compare
            },
            false => self.compare,
        }
    }

    fn set_outputs(&mut self, are_on: bool) {
        self.are_on = (are_on || self.is_stuck_on) && !self.has_tripped;
    }

    fn are_outputs_on(&self) -> bool {
        self.are_on
    }

    fn has_tripped(&self) -> bool {
        self.has_tripped
    }

    fn clear_trip(&mut self) {
        self.has_tripped = false;
    }
}

/// A transfer that an encoder answers, complete after a delay.
#[derive(Debug, Default)]
pub struct EncoderTransfer {
    /// Word of the encoder, 18 bits.
    pub word: u32,
    /// Bits that an aborted transfer leaves behind.
    pub residue: bool,
    pub is_running: bool,
    pub was_aborted: bool,
    /// Whether time has passed since the start.
    pub has_ended: Rc<RefCell<bool>>,
}

impl Transfer for EncoderTransfer {
    fn abort(&mut self) {
        self.was_aborted = self.is_running;
        self.is_running = false;
    }

    fn start(&mut self) {
        self.is_running = true;
        *self.has_ended.borrow_mut() = false;
    }

    fn end(&mut self) -> bool {
        let ended = self.is_running && *self.has_ended.borrow();
        self.is_running &= !ended;
        ended
    }

    fn bytes(&self) -> [u8; 3] {
        let shift = if self.residue && self.was_aborted {
            6
        } else {
            5
        };
        let [_, a, b, c] = (self.word << shift).to_be_bytes();
        [a, b, c]
    }
}

/// What a controller does and has on its bus, shared with the test.
#[derive(Debug, Default)]
pub struct Bus {
    /// Frames that the controller transmitted, in their order.
    pub transmitted: Vec<CanFrame>,
    /// Frames that it will receive.
    pub received: VecDeque<CanFrame>,
    /// Mailboxes with a frame.
    pub mailboxes: [Option<CanFrame>; 3],
    /// Events that the controller reports.
    pub activity: Option<Activity>,
    pub is_off: bool,
    pub has_overrun: bool,
    /// How it takes part, with the bit rate; `None` while it is off the bus.
    pub joined: Option<(u16, Mode)>,
    transmitted_since: u32,
}

impl Bus {
    /// The bus takes the frames of all mailboxes.
    pub fn carry(&mut self) {
        for mailbox in &mut self.mailboxes {
            let Some(frame) = mailbox.take() else {
                continue;
            };
            self.transmitted.push(frame);
            self.transmitted_since += 1;
            if self.joined.is_some_and(|(_, mode)| mode == Mode::LoopBack) {
                self.received.push_back(frame);
            }
        }
    }
}

/// A controller with three mailboxes.
#[derive(Debug, Default, Clone)]
pub struct Port(pub Rc<RefCell<Bus>>);

impl CanPort for Port {
    const MAILBOXES: usize = 3;

    fn is_free(&self, mailbox: usize) -> bool {
        self.0.borrow().mailboxes[mailbox].is_none()
    }

    fn put(&mut self, mailbox: usize, frame: &CanFrame) {
        let old = self.0.borrow_mut().mailboxes[mailbox].replace(*frame);
        assert_eq!(old, None, "the mailbox was free");
    }

    fn abort(&mut self, mailboxes: u32) {
        for (index, mailbox) in self.0.borrow_mut().mailboxes.iter_mut().enumerate() {
            if mailboxes >> index & 1 != 0 {
                *mailbox = None;
            }
        }
    }

    fn take_transmitted(&mut self) -> u32 {
        std::mem::take(&mut self.0.borrow_mut().transmitted_since)
    }

    fn receive(&mut self) -> Option<CanFrame> {
        self.0.borrow_mut().received.pop_front()
    }

    fn take_overrun(&mut self) -> bool {
        std::mem::take(&mut self.0.borrow_mut().has_overrun)
    }

    fn leave(&mut self) {
        let mut bus = self.0.borrow_mut();
        bus.joined = None;
        bus.is_off = false;
    }

    fn has_left(&self) -> bool {
        self.0.borrow().joined.is_none()
    }

    fn join(&mut self, kbit_s: u16, mode: Mode) {
        self.0.borrow_mut().joined = Some((kbit_s, mode));
    }

    fn is_off(&mut self) -> bool {
        self.0.borrow().is_off
    }

    fn take_activity(&mut self) -> Activity {
        let activity = self.0.borrow_mut().activity.take();
        activity.unwrap_or(Activity::None)
    }

    fn take_state(&mut self) -> BusState {
        match self.0.borrow().is_off {
            true => BusState::Off,
            false => BusState::Active,
        }
    }
}

/// A NOR flash with two sectors, which writes `WRITE` bytes at once, and defects to seed.
#[derive(Debug)]
pub struct Nor<const WRITE: usize> {
    pub bytes: Vec<u8>,
    /// A bit that stays 0.
    pub stuck_bit: Option<usize>,
    /// Its erases fail.
    pub fails: bool,
}

const SECTOR: usize = 1024;

impl<const WRITE: usize> Nor<WRITE> {
    /// A flash with content.
    pub fn new() -> Self {
        Self {
            bytes: vec![0x5a; 2 * SECTOR],
            stuck_bit: None,
            fails: false,
        }
    }

    fn stick(&mut self) {
        if let Some(bit) = self.stuck_bit {
            self.bytes[bit / 8] &= !(1 << (bit % 8));
        }
    }
}

impl<const WRITE: usize> ErrorType for Nor<WRITE> {
    type Error = NorFlashErrorKind;
}

impl<const WRITE: usize> ReadNorFlash for Nor<WRITE> {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        check_read(self, offset, bytes.len())?;
        bytes.copy_from_slice(&self.bytes[offset as usize..][..bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl<const WRITE: usize> NorFlash for Nor<WRITE> {
    const WRITE_SIZE: usize = WRITE;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        check_erase(self, from, to)?;
        if self.fails {
            return Err(NorFlashErrorKind::Other);
        }
        self.bytes[from as usize..to as usize].fill(0xff);
        self.stick();
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        check_write(self, offset, bytes.len())?;
        for (cell, byte) in self.bytes[offset as usize..].iter_mut().zip(bytes) {
            assert_eq!(*cell, 0xff, "written twice without an erase");
            *cell = *byte;
        }
        self.stick();
        Ok(())
    }
}
