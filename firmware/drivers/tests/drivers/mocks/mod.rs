//! Hardware in memory: a timer and a CAN controller.

use std::{cell::RefCell, collections::VecDeque, rc::Rc};

use canopen::CanFrame;
use drivers::{
    bridge::{Compare, PwmTimer},
    can::{Activity, BusState, CanPort, Mode},
};

/// A timer with a break input.
#[derive(Debug, Default)]
pub struct Timer {
    pub compare: Option<Compare>,
    pub are_on: bool,
    pub has_tripped: bool,
}

impl Timer {
    /// A moment of over-current.
    pub fn trip(&mut self) {
        self.has_tripped = true;
        self.are_on = false;
    }
}

impl PwmTimer for Timer {
    fn set_compare(&mut self, compare: Compare) {
        self.compare = Some(compare);
    }

    fn set_outputs(&mut self, are_on: bool) {
        self.are_on = are_on && !self.has_tripped;
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
