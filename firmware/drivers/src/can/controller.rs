//! The controller with its queues. No operation waits for the bus.
//!
//! Frames to be transmitted wait in two queues for a mailbox ([`TransmitQueues`]).
//!
//! The controller joins a bus listening, without acknowledging or signalling errors: a board that
//! is set to another bit rate would destroy every frame. It takes part once it has received a valid
//! frame of any identifier, or after [`QUIET_MS`] without traffic and errors. A frame that no other
//! station acknowledges is valid too once its transmitter is error-passive, after 16 attempts: two
//! stations suffice.
//!
//! After bus-off it waits, for [`BACK_OFF_MS`] at first and twice as long after each further
//! bus-off without a frame transmitted or received in between, for [`LONGEST_BACK_OFF_MS`] at most;
//! then it recovers, in 128 times 11 recessive bits (ISO 11898-1, fault confinement), and listens
//! again.

use canopen::CanFrame;
use firmware::application::BusState;
use model_core::time::UPDATE_RATE_HZ;

use super::{Activity, CanPort, Mode};

/// Time without traffic and errors after which a listening controller takes part.
const QUIET_MS: u32 = 10;

/// Time off the bus after the first bus-off, and the longest one.
const BACK_OFF_MS: u32 = 10;
const LONGEST_BACK_OFF_MS: u32 = 1_280;

/// The frames to be transmitted, in two queues.
pub trait TransmitQueues {
    /// Removes the oldest frame of the process data, which may be discarded.
    fn next_process_data(&mut self) -> Option<CanFrame>;

    /// Removes the oldest of all other frames, which go first.
    fn next_other(&mut self) -> Option<CanFrame>;
}

/// How the controller takes part in the bus.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Participation {
    /// It shall join the bus, once it has left it.
    Joining(Mode),
    /// It receives and does not acknowledge.
    Listening,
    /// It takes part.
    Full,
    /// Bus-off.
    Off,
}

/// The controller without its receive FIFO, for which another interrupt calls
/// [`super::receive`]. Times are numbers of update periods, of 31 bits, which wrap.
pub struct CanController<P, Q> {
    port: P,
    queues: Q,
    kbit_s: u16,
    participation: Participation,
    /// Number of the update period in which the quiet time, or the time off the bus, began.
    since: u32,
    /// Time off the bus at the next bus-off.
    back_off_ms: u32,
    /// Mailboxes that hold process data, one bit each.
    holds_process_data: u32,
}

impl<P: CanPort, Q: TransmitQueues> CanController<P, Q> {
    /// Joins the bus with this bit rate, kbit/s, by a port that has left the bus, or does so.
    pub fn new(port: P, kbit_s: u16, queues: Q) -> Self {
        let mut controller = Self {
            port,
            queues,
            kbit_s,
            participation: Participation::Joining(Mode::Listening),
            since: 0,
            back_off_ms: BACK_OFF_MS,
            holds_process_data: 0,
        };
        controller.update(0);
        controller
    }

    /// Changes to another bit rate, kbit/s, in this update period; frames that are not transmitted
    /// yet are discarded.
    pub fn set_bit_rate(&mut self, kbit_s: u16, period: u32) {
        while self.queues.next_other().is_some() {}
        while self.queues.next_process_data().is_some() {}
        self.port.abort(u32::MAX);
        self.kbit_s = kbit_s;
        self.back_off_ms = BACK_OFF_MS;
        self.join(Mode::Listening, period);
    }

    /// Leaves the bus, and joins it again.
    fn join(&mut self, mode: Mode, period: u32) {
        self.participation = Participation::Joining(mode);
        self.port.leave();
        self.join_if_left(mode, period);
    }

    /// Joins the bus if the controller has left it.
    fn join_if_left(&mut self, mode: Mode, period: u32) {
        if !self.port.has_left() {
            return;
        }
        self.port.join(self.kbit_s, mode);
        self.since = period;
        self.participation = match mode {
            Mode::Listening => Participation::Listening,
            Mode::Full | Mode::LoopBack => Participation::Full,
        };
    }

    /// Joins the bus, ends listening, and returns after bus-off, each when it is time: call this
    /// periodically. Returns whether the controller has gone bus-off since the last call.
    pub fn update(&mut self, period: u32) -> bool {
        let is_off = self.port.is_off();
        match self.participation {
            Participation::Joining(mode) => self.join_if_left(mode, period),
            Participation::Listening if !is_off => self.listen(period),
            Participation::Full if is_off => {
                self.since = period;
                self.participation = Participation::Off;
                return true;
            }
            Participation::Off if self.has_elapsed(self.back_off_ms, period) => {
                self.back_off_ms = (self.back_off_ms * 2).min(LONGEST_BACK_OFF_MS);
                self.join(Mode::Listening, period);
            }
            _ => {}
        }
        false
    }

    fn listen(&mut self, period: u32) {
        match self.port.take_activity() {
            Activity::Frame => {
                self.back_off_ms = BACK_OFF_MS;
                self.join(Mode::Full, period);
            }
            // Also behind the recovery from bus-off.
            Activity::None if self.has_elapsed(QUIET_MS, period) => self.join(Mode::Full, period),
            Activity::None => {}
            Activity::Error => self.since = period,
        }
    }

    /// Whether this number of milliseconds has elapsed since the start of the running time.
    fn has_elapsed(&self, ms: u32, period: u32) -> bool {
        let elapsed = period.wrapping_sub(self.since) & (u32::MAX >> 1);
        elapsed >= ms * (UPDATE_RATE_HZ / 1000)
    }

    /// Acknowledges the mailboxes that have become free; returns how many of their frames were
    /// transmitted.
    pub fn take_transmitted(&mut self) -> u32 {
        let count = self.port.take_transmitted();
        if count > 0 {
            self.back_off_ms = BACK_OFF_MS;
        }
        count
    }

    /// Moves frames from the queues into the free mailboxes.
    pub fn fill_mailboxes(&mut self) {
        for mailbox in 0..P::MAILBOXES {
            if !self.port.is_free(mailbox) {
                continue;
            }
            let bit = 1 << mailbox;
            let other = self.queues.next_other();
            self.holds_process_data &= !bit;
            if other.is_none() {
                self.holds_process_data |= bit;
            }
            let Some(frame) = other.or_else(|| self.queues.next_process_data()) else {
                return;
            };
            self.port.put(mailbox, &frame);
        }
    }

    /// Discards the process data that waits, in the queue and in mailboxes; a frame on the bus is
    /// transmitted to its end. Returns the number of frames.
    pub fn discard_process_data(&mut self) -> u32 {
        let mut count = 0;
        while self.queues.next_process_data().is_some() {
            count += 1;
        }
        let holds = self.holds_process_data;
        let pending = (0..P::MAILBOXES).filter(|mailbox| !self.port.is_free(*mailbox));
        count += pending.filter(|mailbox| holds & 1 << mailbox != 0).count() as u32;
        self.port.abort(holds);
        count
    }

    /// Present state of the controller; acknowledges its interrupt.
    pub fn take_state(&mut self) -> BusState {
        self.port.take_state()
    }
}
