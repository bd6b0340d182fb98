//! The controller FDCAN of the STM32H7 (RM0433, chapter 56) for classical CAN: dedicated transmit
//! buffers, receive FIFO 0, filters with two identifiers or with an extended one and a mask, error
//! counters, bus-off and its recovery, both interrupt lines, bus monitoring and loop-back mode.
//!
//! Not modelled, and reported when the program selects it: CAN FD, transmit FIFO and queue, receive
//! FIFO 1 and buffers, time stamps, other filters, messages other than of eight bytes.

mod device;
mod filters;
mod memory;
mod registers;
#[cfg(test)]
mod tests;
mod transmit;

use rigless::device::Level;
use rigless::soc::RegisterSpec;
use rigless::time::EventId;

pub use self::memory::{MESSAGE_RAM_BYTES, MessageRam};
use self::registers::{LBCK, LastError, cccr};
use super::{BitTiming, ErrorCounters, ErrorState, Station, Transfer, Wire};
use crate::faults::FilterBit;

/// How the controller takes part in the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mode {
    /// `INIT`.
    Initialising,
    /// Waits for 11 recessive bits, or 129 times as many after bus-off, until this instant, ns.
    Joining { ready_ns: u64 },
    /// On the bus.
    Running,
}

/// The frame that the controller transmits or receives.
#[derive(Debug, Clone, Copy)]
struct FrameInProgress {
    transfer: Transfer,
    ends_ns: u64,
    /// Buffer of a transmitted frame.
    buffer: Option<u32>,
    /// Index of the controller among the stations.
    index: usize,
    /// Whether it is not on the bus: internal loop-back mode.
    is_internal: bool,
}

/// A receive FIFO: indices of its elements.
#[derive(Debug, Clone, Copy, Default)]
struct Fifo {
    get: u32,
    level: u32,
}

/// Registers that the program writes and nothing else changes.
#[derive(Debug, Clone, Copy, Default)]
struct Settings {
    test: u32,
    bit_timing: u32,
    enabled: u32,
    line_select: u32,
    line_enable: u32,
    global_filter: u32,
    standard_filters: u32,
    extended_filters: u32,
    fifo: u32,
    buffers: u32,
    complete_enabled: u32,
    cancelled_enabled: u32,
}

/// A controller, on its own [`Wire`] with external ports or on a bus that its user shares
/// among several controllers.
#[derive(Debug)]
pub struct FdCan {
    /// The bus with its ports; `None` if it is shared: its owner then calls [`FdCan::begin`].
    pub wire: Option<Wire>,
    ram: MessageRam,
    layout: &'static [RegisterSpec],
    clock_hz: u64,
    control: u32,
    settings: Settings,
    mode: Mode,
    fifo: Fifo,
    /// Buffers to be transmitted, `TXBRP`; those whose cancellation waits for the end of a frame;
    /// transmitted, `TXBTO`; cancelled, `TXBCF`.
    pending: u32,
    cancelling: u32,
    transmitted: u32,
    cancelled: u32,
    counters: ErrorCounters,
    last_error: LastError,
    flags: u32,
    /// States as last flagged: error-passive, warning, bus-off.
    was: [bool; 3],
    current: Option<FrameInProgress>,
    wake: Option<EventId>,
    /// Time since which it has had a frame to transmit, ns.
    offers_since_ns: Option<u64>,
    lines: [Level; 2],
}

impl FdCan {
    /// A controller after a reset; `layout` is that of its window on the bus.
    pub fn new(wire: Option<Wire>, ram: MessageRam, layout: &'static [RegisterSpec]) -> Self {
        Self {
            wire,
            ram,
            layout,
            clock_hz: 0,
            control: cccr::INIT,
            settings: Settings::default(),
            mode: Mode::Initialising,
            fifo: Fifo::default(),
            pending: 0,
            cancelling: 0,
            transmitted: 0,
            cancelled: 0,
            counters: ErrorCounters::default(),
            last_error: LastError::NoChange,
            flags: 0,
            was: [false; 3],
            current: None,
            wake: None,
            offers_since_ns: None,
            lines: [Level::Low; 2],
        }
    }

    /// Resets the controller; bus, message RAM and clock are preserved.
    pub fn restart(&mut self) {
        let mut wire = self.wire.take();
        if let (Some(wire), Some(current)) = (&mut wire, &self.current) {
            wire.abandon(current.transfer.sender);
        }
        *self = Self {
            clock_hz: self.clock_hz,
            ..Self::new(wire, self.ram.clone(), self.layout)
        };
    }

    /// Flips a bit of the filters in the message RAM.
    pub fn flip_filter(&mut self, bit: FilterBit) {
        let start = filters::list(self.settings.standard_filters, 0).0;
        let (word, bit) = match bit {
            FilterBit::Identifiers(bit) => (bit / 32, bit % 32),
            FilterBit::Activation(element) => (element, filters::CONFIGURATION),
        };
        let offset = start + 4 * word;
        self.ram.write(offset, self.ram.word(offset) ^ 1 << bit);
    }

    fn is(&self, control: u32) -> bool {
        self.control & control != 0
    }

    fn is_looped(&self) -> bool {
        self.is(cccr::TEST) && self.settings.test & LBCK != 0
    }

    /// Whether frames remain within the controller.
    fn is_internal(&self) -> bool {
        self.is_looped() && self.is(cccr::MON)
    }

    fn is_bus_off(&self) -> bool {
        self.counters.state() == ErrorState::BusOff
    }

    fn timing(&self) -> Option<BitTiming> {
        let field = |shift: u32, mask: u32| u64::from(self.settings.bit_timing >> shift & mask) + 1;
        let segments = (field(8, 0xff), field(0, 0x7f));
        BitTiming::of_quanta(field(16, 0x1ff), segments, field(25, 0x7f), self.clock_hz)
    }

    fn bits_ns(&self, bits: u32) -> u64 {
        self.timing().map_or(0, |timing| timing.bits_ns(bits))
    }

    /// The controller as a station; `None` while it is not on the bus.
    pub fn station(&self) -> Option<Station> {
        if self.mode != Mode::Running || self.is_bus_off() {
            return None;
        }
        let transmits = !self.is(cccr::MON) || self.is_looped();
        Some(Station {
            timing: self.timing()?,
            state: self.counters.state(),
            offer: self
                .next_buffer()
                .map(|(_, frame)| frame)
                .filter(|_| transmits),
            is_silent: self.is(cccr::MON),
            needs_acknowledge: !self.is_looped(),
        })
    }

    /// Time since which it has had a frame to transmit, ns; `None` without one.
    pub fn offers_since_ns(&self) -> Option<u64> {
        self.offers_since_ns
    }

    fn update_offer(&mut self, now_ns: u64) {
        let offers = self
            .station()
            .is_some_and(|station| station.offer.is_some());
        self.offers_since_ns = offers.then(|| self.offers_since_ns.unwrap_or(now_ns));
    }
}
