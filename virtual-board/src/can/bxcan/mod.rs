//! The controller bxCAN of the STM32 (RM0090, chapter 32): three mailboxes, two FIFOs, 28 filter
//! banks, error counters, bus-off and its recovery, all interrupts, silent and loop-back mode,
//! time stamps.
//!
//! Not modelled: debug freeze (`DBF`: a halted core stops the virtual time), and wake-up by bus
//! activity within a frame (it wakes up at the start of a frame).

mod device;
mod mailboxes;
mod mode;
mod receive;
mod status;
#[cfg(test)]
mod tests;
mod transmit;

use rigless::device::Level;
use rigless::time::EventId;

use self::mailboxes::Mailboxes;
use self::mode::Mode;
use self::status::Status;
use super::fifo::Fifo;
use super::filters::Filters;
use super::{BitTiming, ErrorCounters, ErrorState, Station, Transfer, Wire};
use crate::faults::FilterBit;

/// Bits of `CAN_MCR`.
mod mcr {
    pub const INRQ: u32 = 1;
    pub const SLEEP: u32 = 1 << 1;
    pub const TXFP: u32 = 1 << 2;
    pub const RFLM: u32 = 1 << 3;
    pub const NART: u32 = 1 << 4;
    pub const AWUM: u32 = 1 << 5;
    pub const ABOM: u32 = 1 << 6;
    pub const TTCM: u32 = 1 << 7;
    pub const RESET: u32 = 1 << 15;
}

/// Bits of `CAN_BTR`.
mod btr {
    pub const LBKM: u32 = 1 << 30;
    pub const SILM: u32 = 1 << 31;
}

/// The frame that the controller transmits or receives.
#[derive(Debug, Clone, Copy)]
struct FrameInProgress {
    transfer: Transfer,
    ends_ns: u64,
    started_ns: u64,
    /// Mailbox of a transmitted frame.
    mailbox: Option<usize>,
    /// Index of the controller among the stations.
    index: usize,
    /// Whether it is not on the bus: silent loop-back mode.
    is_internal: bool,
}

/// A controller, on its own [`Wire`] with external ports or on a bus that its user shares
/// among several controllers.
#[derive(Debug)]
pub struct BxCan {
    /// The bus with its ports; `None` if it is shared: its owner then calls [`BxCan::begin`].
    pub wire: Option<Wire>,
    clock_hz: u64,
    control: u32,
    bit_timing: u32,
    mode: Mode,
    mailboxes: Mailboxes,
    fifos: [Fifo; 2],
    filters: Filters,
    counters: ErrorCounters,
    status: Status,
    current: Option<FrameInProgress>,
    /// The next event, and its instant, ns.
    wake: Option<(u64, EventId)>,
    /// Whether the registers show the filters.
    shows_filters: bool,
    /// Time since which it has had a frame to transmit, ns.
    offers_since_ns: Option<u64>,
    lines: [Level; 4],
    /// Zero of the time stamps, ns.
    epoch_ns: u64,
}

/// Reset value of `CAN_MCR`: sleep mode, frozen in debug.
const CONTROL_AFTER_RESET: u32 = 0x0001_0002;

/// Reset value of `CAN_BTR`.
const BIT_TIMING_AFTER_RESET: u32 = 0x0123_0000;

impl BxCan {
    /// A controller after a reset, on its own bus or on a shared one.
    pub fn new(wire: Option<Wire>) -> Self {
        Self {
            wire,
            clock_hz: 16_000_000,
            control: CONTROL_AFTER_RESET,
            bit_timing: BIT_TIMING_AFTER_RESET,
            mode: Mode::Asleep,
            mailboxes: Mailboxes::default(),
            fifos: Default::default(),
            filters: Filters::default(),
            counters: ErrorCounters::default(),
            status: Status::default(),
            current: None,
            wake: None,
            shows_filters: false,
            offers_since_ns: None,
            lines: [Level::Low; 4],
            epoch_ns: 0,
        }
    }

    /// Its error counters.
    pub fn counters(&self) -> ErrorCounters {
        self.counters
    }

    /// Frames in both FIFOs.
    pub fn unread(&self) -> usize {
        self.fifos.iter().map(Fifo::len).sum()
    }

    /// Resets the controller; bus and clock are preserved.
    pub fn restart(&mut self) {
        let mut wire = self.wire.take();
        if let (Some(wire), Some(current)) = (&mut wire, &self.current) {
            wire.abandon(current.transfer.sender);
        }
        let clock_hz = self.clock_hz;
        *self = Self {
            clock_hz,
            ..Self::new(wire)
        };
    }

    /// Flips a bit of the acceptance filter.
    pub fn flip_filter(&mut self, bit: FilterBit) {
        self.filters.flip(bit);
        self.shows_filters = false;
    }

    fn is(&self, control: u32) -> bool {
        self.control & control != 0
    }

    fn is_silent(&self) -> bool {
        self.bit_timing & btr::SILM != 0
    }

    fn is_looped(&self) -> bool {
        self.bit_timing & btr::LBKM != 0
    }

    fn timing(&self) -> Option<BitTiming> {
        BitTiming::from_btr(self.bit_timing, self.clock_hz)
    }

    /// The controller as a station; `None` while it is not on the bus.
    pub fn station(&self, now_ns: u64) -> Option<Station> {
        if self.mode != Mode::Running || self.counters.state() == ErrorState::BusOff {
            return None;
        }
        Some(Station {
            timing: self.timing()?,
            state: self.counters.state(),
            offer: self
                .offer(now_ns)
                .filter(|_| !self.is_silent() || self.is_looped()),
            is_silent: self.is_silent(),
            needs_acknowledge: !self.is_looped(),
        })
    }

    /// Whether it has a frame to transmit.
    fn offers(&self, now_ns: u64) -> bool {
        let offers = |station: Station| station.offer.is_some();
        self.mailboxes.has_pending() && self.station(now_ns).is_some_and(offers)
    }

    /// Updates the time since which it has a frame to transmit.
    fn update_offer(&mut self, now_ns: u64) {
        self.offers_since_ns = if self.offers(now_ns) {
            self.offers_since_ns.or(Some(now_ns))
        } else {
            None
        };
    }

    /// Time since which it has had a frame to transmit, ns; `None` without one.
    pub fn offers_since_ns(&self) -> Option<u64> {
        self.offers_since_ns
    }

    /// Time stamp of an instant: bit times, modulo 2^16.
    fn stamp(&self, at_ns: u64) -> u16 {
        let bit_ps = self.timing().map_or(1, |timing| timing.bit_ps.max(1));
        (at_ns.saturating_sub(self.epoch_ns) * 1000 / bit_ps) as u16
    }
}
