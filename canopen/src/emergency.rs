//! Emergency object, error register and history (CiA 301, 7.2.7).

use crate::Abort;
use crate::message::{IDENTIFIER, Message, cob_id_change_allowed};
use crate::ring::Ring;
use crate::timer::Timer;

/// Maximum number of simultaneously active errors.
const ACTIVE: usize = 16;
/// Length of the error history 1003h; the dictionary determines how many entries are visible.
const HISTORY: usize = 8;
/// Bit 31 of 1014h: EMCY does not exist. Bit 30 is reserved and always 0.
const INVALID: u32 = 1 << 31;
const RESERVED: u32 = 1 << 30;
/// Maximum number of EMCY messages that wait for the bus or for the inhibit time.
const QUEUE: usize = 8;

/// Error code of an EMCY message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ErrorCode(pub u16);

impl ErrorCode {
    /// Error reset, or no error.
    pub const NONE: Self = Self(0x0000);
    /// CAN overrun: frames were lost.
    pub const CAN_OVERRUN: Self = Self(0x8110);
    /// CAN controller in error passive mode.
    pub const CAN_PASSIVE: Self = Self(0x8120);
    /// Heartbeat of a consumed producer timed out.
    pub const HEARTBEAT: Self = Self(0x8130);
    /// Recovered from bus-off.
    pub const BUS_OFF_RECOVERED: Self = Self(0x8140);
    /// PDO not processed due to length error.
    pub const PDO_LENGTH: Self = Self(0x8210);
    /// Protocol error: an RPDO has a value that its object refuses.
    pub const PDO_VALUE: Self = Self(0x8200);
    /// Unexpected SYNC data length.
    pub const SYNC_LENGTH: Self = Self(0x8240);
    /// RPDO timeout.
    pub const RPDO_TIMEOUT: Self = Self(0x8250);
}

/// First error instance of the application. The server's own instances, node-IDs and PDO numbers,
/// are below.
const FIRST_APPLICATION_INSTANCE: u8 = 128;

/// Errors of the server that a reset communication clears.
const CLEARED_BY_RESET: [ErrorCode; 5] = [
    ErrorCode::HEARTBEAT,
    ErrorCode::PDO_LENGTH,
    ErrorCode::PDO_VALUE,
    ErrorCode::SYNC_LENGTH,
    ErrorCode::RPDO_TIMEOUT,
];

/// Bits of the error register 1001h.
pub mod register {
    /// Generic error; set with every other bit.
    pub const GENERIC: u8 = 1 << 0;
    /// Current.
    pub const CURRENT: u8 = 1 << 1;
    /// Voltage.
    pub const VOLTAGE: u8 = 1 << 2;
    /// Temperature.
    pub const TEMPERATURE: u8 = 1 << 3;
    /// Communication error.
    pub const COMMUNICATION: u8 = 1 << 4;
    /// Device profile specific.
    pub const PROFILE: u8 = 1 << 5;
    /// Manufacturer-specific.
    pub const MANUFACTURER: u8 = 1 << 7;
}

/// An error raised by the application or by the server.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Emergency {
    /// Error code.
    pub code: ErrorCode,
    /// Bits of the error register; [`register::GENERIC`] is added.
    pub register: u8,
    /// Instance, byte 3 of the message. Code and instance together identify an error. Errors of the
    /// server have instances below 128.
    pub instance: u8,
    /// Bytes 4 to 7 of the message, manufacturer-specific.
    pub information: [u8; 4],
}

impl Emergency {
    /// An error with instance 0 and no manufacturer-specific information.
    #[must_use]
    pub const fn new(code: ErrorCode, register: u8) -> Self {
        Self {
            code,
            register,
            instance: 0,
            information: [0; 4],
        }
    }

    pub(crate) const fn communication(code: ErrorCode, instance: u8) -> Self {
        Self {
            code,
            register: register::COMMUNICATION,
            instance,
            information: [0; 4],
        }
    }
}

/// EMCY producer with objects 1001h, 1003h, 1014h and 1015h.
#[derive(Debug)]
pub(crate) struct EmergencyProducer {
    cob_id: u32,
    inhibit_100us: u16,
    active: [Emergency; ACTIVE],
    /// Number of active errors, the first of `active`.
    actives: usize,
    /// Ring of errors; the newest is at index `newest`.
    history: [u32; HISTORY],
    newest: usize,
    recorded: usize,
    queue: Ring<[u8; 8], QUEUE>,
    /// Messages at the head of the queue that a stop by the error behaviour waits for.
    before_stop: usize,
    inhibit: Timer,
}

impl EmergencyProducer {
    /// Initial state; 1014h is not valid until [`EmergencyProducer::reset_communication`].
    pub const NEW: Self = Self {
        cob_id: 0,
        inhibit_100us: 0,
        active: [Emergency::communication(ErrorCode::NONE, 0); ACTIVE],
        actives: 0,
        history: [0; HISTORY],
        newest: 0,
        recorded: 0,
        queue: Ring::new([0; 8]),
        before_stop: 0,
        inhibit: Timer::EXPIRED,
    };

    /// Keeps active errors, discards messages not yet sent, and allows any value for 1014h.
    pub fn reset_communication(&mut self) {
        self.cob_id = INVALID;
        self.inhibit_100us = 0;
        self.queue.clear();
        self.before_stop = 0;
        self.inhibit = Timer::EXPIRED;
        let is_cleared = |error: &Emergency| {
            error.instance < FIRST_APPLICATION_INSTANCE && CLEARED_BY_RESET.contains(&error.code)
        };
        while let Some(at) = self.active().iter().position(is_cleared) {
            self.remove(at);
        }
    }

    /// Object 1001h.
    pub fn register(&self) -> u8 {
        self.active()
            .iter()
            .fold(0, |bits, error| bits | error.register | register::GENERIC)
    }

    /// Returns whether the error is new. An error beyond the 16 that can be active is transmitted
    /// and recorded, but cannot be cleared individually.
    pub fn raise(&mut self, error: Emergency) -> bool {
        if self.position(error.code, error.instance).is_some() {
            return false;
        }
        if let Some(free) = self.active.get_mut(self.actives) {
            *free = error;
            self.actives += 1;
        }
        self.record(error);
        self.send(error.code, error.register, error);
        true
    }

    /// Returns whether the error was active.
    pub fn clear(&mut self, code: ErrorCode, instance: u8) -> bool {
        let found = self.position(code, instance).and_then(|at| self.remove(at));
        if let Some(error) = found {
            self.send(ErrorCode::NONE, 0, error);
        }
        found.is_some()
    }

    fn position(&self, code: ErrorCode, instance: u8) -> Option<usize> {
        self.active()
            .iter()
            .position(|error| error.code == code && error.instance == instance)
    }

    /// The active errors.
    fn active(&self) -> &[Emergency] {
        self.active.get(..self.actives).unwrap_or_default()
    }

    /// Removes an active error; the last one takes its place.
    fn remove(&mut self, at: usize) -> Option<Emergency> {
        let (last, _) = self.active.get_mut(..self.actives)?.split_last_mut()?;
        let last = *last;
        let removed = core::mem::replace(self.active.get_mut(at)?, last);
        self.actives -= 1;
        Some(removed)
    }

    fn record(&mut self, error: Emergency) {
        self.newest = (self.newest + HISTORY - 1) % HISTORY;
        if let Some(slot) = self.history.get_mut(self.newest) {
            *slot = u32::from(error.instance) << 16 | u32::from(error.code.0);
        }
        self.recorded = (self.recorded + 1).min(HISTORY);
    }

    fn send(&mut self, code: ErrorCode, register: u8, error: Emergency) {
        let [low, high] = code.0.to_le_bytes();
        let [a, b, c, d] = error.information;
        // An error beyond those that can be active is missing from the register, but its generic
        // bit is set.
        let bits = self.register() | register;
        // If the queue is full, the error is only in the history.
        self.queue
            .push([low, high, bits, error.instance, a, b, c, d]);
    }

    pub fn advance(&mut self, elapsed: Timer) {
        self.inhibit.advance(elapsed);
    }

    /// The messages of the errors so far belong to the state before the one that they cause.
    pub fn mark_before_stop(&mut self) {
        self.before_stop = self.queue.len();
    }

    /// The next message from before a stop.
    pub fn transmit_before_stop(&mut self) -> Option<Message> {
        if self.before_stop == 0 {
            return None;
        }
        self.transmit()
    }

    pub fn transmit(&mut self) -> Option<Message> {
        if self.cob_id & INVALID != 0 || !self.inhibit.is_expired() {
            return None;
        }
        let data = self.queue.pop()?;
        self.before_stop = self.before_stop.saturating_sub(1);
        self.inhibit = Timer::from_100us(self.inhibit_100us);
        Some(Message::new(self.identifier(), &data))
    }

    /// Reads object 1003h; `shown` is the number of entries in the dictionary.
    pub fn history(&self, sub: u8, shown: usize) -> Result<u32, Abort> {
        let recorded = self.recorded.min(shown);
        match usize::from(sub).checked_sub(1) {
            None => Ok(recorded as u32),
            Some(at) if at < recorded => {
                let at = (self.newest + at) % HISTORY;
                self.history.get(at).copied().ok_or(Abort::NoData)
            }
            Some(_) => Err(Abort::NoData),
        }
    }

    pub fn clear_history(&mut self, value: u32) -> Result<(), Abort> {
        if value != 0 {
            return Err(Abort::Value);
        }
        self.recorded = 0;
        Ok(())
    }

    pub fn cob_id(&self) -> u32 {
        self.cob_id
    }

    /// The identifier of the messages, with the bit of an extended one.
    pub fn identifier(&self) -> u32 {
        self.cob_id & IDENTIFIER
    }

    pub fn set_cob_id(&mut self, new: u32) -> Result<(), Abort> {
        let valid = new & INVALID == 0;
        let in_use = self.cob_id & INVALID == 0;
        if new & RESERVED != 0 || (valid && !cob_id_change_allowed(new, self.cob_id, in_use)) {
            return Err(Abort::Value);
        }
        self.cob_id = new;
        Ok(())
    }

    pub fn inhibit_100us(&self) -> u16 {
        self.inhibit_100us
    }

    pub fn set_inhibit(&mut self, time_100us: u16) {
        self.inhibit_100us = time_100us;
    }
}
