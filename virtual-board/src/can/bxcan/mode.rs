//! Initialisation, sleep, joining the bus, bus-off and its recovery (RM0090, sections 32.4 and
//! 32.7.6).

use rigless::chip::can::{BUS_IDLE_BITS, INTERMISSION_BITS};

use super::super::{ErrorCounters, ErrorState};
use super::{BxCan, mcr};

/// Operating mode of the controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mode {
    /// `SLAK`.
    Asleep,
    /// `INAK`.
    Initialising,
    /// Waits for 11 recessive bits, until this instant without traffic, ns; still `INAK`.
    Joining { ready_ns: u64 },
    /// On the bus.
    Running,
    /// Bus-off, until this instant, ns, if it recovers automatically.
    BusOff { recovers_ns: Option<u64> },
}

/// Recessive bits after which the bus is idle.
const IDLE_BITS: u32 = BUS_IDLE_BITS;

/// Idle sequences of a recovery from bus-off.
const RECOVERY_SEQUENCES: u32 = 128;

impl BxCan {
    /// Executes the requests of `MCR`, unless a frame is in transmission.
    pub(super) fn follow_requests(&mut self, now_ns: u64) {
        let sends = |current: &super::FrameInProgress| current.mailbox.is_some();
        if self.current.as_ref().is_some_and(sends) {
            return;
        }
        let (init, sleep) = (self.is(mcr::INRQ), self.is(mcr::SLEEP));
        let stays_asleep = self.mode == Mode::Asleep && sleep;
        if stays_asleep {
            return;
        }
        if init {
            self.mode = Mode::Initialising;
        } else if sleep {
            self.status.acknowledges_sleep |= self.mode != Mode::Asleep;
            self.mode = Mode::Asleep;
        } else if matches!(self.mode, Mode::Asleep | Mode::Initialising) {
            self.join(now_ns);
        }
    }

    fn bits_ns(&self, bits: u32) -> u64 {
        self.timing().map_or(0, |timing| timing.bits_ns(bits))
    }

    fn join(&mut self, now_ns: u64) {
        self.epoch_ns = now_ns;
        self.mode = Mode::Joining {
            ready_ns: now_ns + self.bits_ns(IDLE_BITS),
        };
    }

    /// Handles the start of a frame on the bus while the controller does not take part.
    pub(super) fn on_traffic(&mut self, ends_ns: u64) {
        // After the delimiter, which counts among the 11 recessive bits.
        let ends_ns = ends_ns + self.bits_ns(INTERMISSION_BITS);
        match &mut self.mode {
            Mode::Joining { ready_ns } => *ready_ns = (*ready_ns).max(ends_ns),
            Mode::Asleep => {
                self.status.woke = true;
                if self.is(mcr::AWUM) {
                    self.control &= !mcr::SLEEP;
                    self.epoch_ns = ends_ns;
                    self.mode = Mode::Joining { ready_ns: ends_ns };
                }
            }
            _ => {}
        }
    }

    /// Time of the next automatic mode change, ns.
    pub(super) fn mode_due_ns(&self) -> Option<u64> {
        match self.mode {
            Mode::Joining { ready_ns } => Some(ready_ns),
            Mode::BusOff { recovers_ns } => recovers_ns,
            _ => None,
        }
    }

    /// Executes an automatic mode change that is due.
    pub(super) fn advance_mode(&mut self, now_ns: u64) {
        if self.mode_due_ns().is_none_or(|due_ns| due_ns > now_ns) {
            return;
        }
        let was_joining = matches!(self.mode, Mode::Joining { .. });
        if was_joining && self.counters.state() == ErrorState::BusOff {
            self.mode = Mode::BusOff {
                recovers_ns: Some(self.recovery_ns(now_ns)),
            };
            return;
        }
        if !was_joining {
            self.counters = ErrorCounters::default();
        }
        self.mode = Mode::Running;
    }

    fn recovery_ns(&self, now_ns: u64) -> u64 {
        now_ns + self.bits_ns(RECOVERY_SEQUENCES * IDLE_BITS)
    }

    /// Enters bus-off if the error counters require it.
    pub(super) fn check_bus_off(&mut self, now_ns: u64) {
        if self.mode == Mode::Running && self.counters.state() == ErrorState::BusOff {
            let recovers_ns = self.is(mcr::ABOM).then(|| self.recovery_ns(now_ns));
            self.mode = Mode::BusOff { recovers_ns };
        }
    }
}
