//! The service password, object 2103h: whether the bus may change what has to do with safety,
//! identity and program.
//!
//! It locks what is locked while the drive is enabled (protection limits, node-ID, bit rate,
//! installation of an image), and the download of an image, the restoration of defaults and the
//! configuration by LSS, which would change the same in other ways. A drive without a password is
//! open. With one it is locked after each reset of the node until the password is written.
//!
//! Each wrong attempt starts a back-off, in which every attempt is refused: trying all 2^32
//! passwords takes millennia. The reset of the node, which any client can command, does not end
//! it. A loss of power does: counting attempts in the flash would let a client wear it out.
//!
//! The password is stored as it is. A hash would not protect it: 2^32 candidates are tried against
//! one in minutes, a debug probe that reads the flash can also write it, and CAN carries the
//! password in clear. It prevents mistakes and changes by clients that do not have it; a listener
//! on the bus learns it.

use canopen::Abort;

use crate::timing::{CONTROL_PERIOD_MS, periods};

/// The longest back-off is this many doublings of a second: 64 s.
const MAX_DOUBLINGS: u8 = 6;

/// State of the service access, object 2103h:2.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum ServiceState {
    /// No password is set.
    Unprotected = 0,
    /// The password has not been given.
    Locked = 1,
    /// The password was given, or was set since the reset of the node.
    Open = 2,
}

/// The service access.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ServiceAccess {
    is_open: bool,
    /// Wrong attempts since the last correct one.
    wrong_attempts: u8,
    /// Control periods until the next attempt is judged.
    back_off: u16,
}

impl ServiceAccess {
    pub const NEW: Self = Self {
        is_open: false,
        wrong_attempts: 0,
        back_off: 0,
    };

    /// One control period.
    pub fn control_period(&mut self) {
        self.back_off = self.back_off.saturating_sub(1);
    }

    /// Locks what a password locks; the back-off goes on.
    pub fn lock(&mut self) {
        self.is_open = false;
    }

    /// The client that sets a password has access until the next reset.
    pub fn password_set(&mut self) {
        self.is_open = true;
    }

    /// The state with this password, 0 for none.
    pub fn state(&self, password: u32) -> ServiceState {
        match (password, self.is_open) {
            (0, _) => ServiceState::Unprotected,
            (_, true) => ServiceState::Open,
            (_, false) => ServiceState::Locked,
        }
    }

    /// Time until the next attempt is judged, ms.
    pub fn back_off_ms(&self) -> u32 {
        u32::from(self.back_off) * CONTROL_PERIOD_MS as u32
    }

    /// Judges an attempt; 0 locks instead.
    ///
    /// # Errors
    /// [`Abort::DeviceState`] during the back-off, whatever the attempt: the state passes by
    /// itself, where 0800 0021h (local control) would mean that somebody has to act at the device.
    /// [`Abort::Value`] for a wrong password.
    pub fn attempt(&mut self, attempt: u32, password: u32) -> Result<(), Abort> {
        if attempt == 0 {
            self.lock();
            return Ok(());
        }
        if password == 0 {
            return Ok(());
        }
        if self.back_off > 0 {
            return Err(Abort::DeviceState);
        }
        if attempt != password {
            let doublings = self.wrong_attempts.min(MAX_DOUBLINGS);
            self.back_off = periods(1000 << doublings);
            self.wrong_attempts = self.wrong_attempts.saturating_add(1);
            return Err(Abort::Value);
        }
        self.wrong_attempts = 0;
        self.is_open = true;
        Ok(())
    }
}
