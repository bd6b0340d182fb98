//! Fault confinement: the error counters of ISO 11898-1, section 12.1.4, as in RM0090, section
//! 32.7.6.

/// Error state of a station.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum ErrorState {
    /// Error-active: sends active error flags.
    Active,
    /// Error-passive: its error flags are recessive and do not destroy frames.
    Passive,
    /// Bus-off: neither transmits nor receives.
    BusOff,
}

/// Transmit and receive error counters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ErrorCounters {
    transmit: u16,
    receive: u8,
}

/// Error warning limit.
const WARNING: u16 = 96;
/// Above this count a station is error-passive.
const PASSIVE: u16 = 127;
/// Above this count a station is bus-off.
const BUS_OFF: u16 = 255;
/// Value of a receive counter above 127 after a valid frame (RM0090).
const AFTER_GOOD_FRAME: u8 = 120;

impl ErrorCounters {
    /// The transmit error counter, 0 to 255, as in its eight bits.
    pub fn transmit(&self) -> u8 {
        self.transmit.min(BUS_OFF) as u8
    }

    /// The receive error counter, 0 to 255.
    pub fn receive(&self) -> u8 {
        self.receive
    }

    /// Error state of the station.
    pub fn state(&self) -> ErrorState {
        if self.transmit > BUS_OFF {
            ErrorState::BusOff
        } else if self.transmit > PASSIVE || u16::from(self.receive) > PASSIVE {
            ErrorState::Passive
        } else {
            ErrorState::Active
        }
    }

    /// Whether a counter has reached the warning limit of 96.
    pub fn is_warning(&self) -> bool {
        self.transmit >= WARNING || u16::from(self.receive) >= WARNING
    }

    /// Counts a transmitted and acknowledged frame.
    pub fn sent(&mut self) {
        self.transmit = self.transmit.saturating_sub(1);
    }

    /// Counts a failed frame of this station. An error-passive transmitter does not count a missing
    /// acknowledgement: alone on the bus it must not become bus-off.
    pub fn send_failed(&mut self, only_acknowledge: bool) {
        if only_acknowledge && self.state() == ErrorState::Passive {
            return;
        }
        self.transmit = (self.transmit + 8).min(BUS_OFF + 8);
    }

    /// Counts a valid received frame.
    pub fn received(&mut self) {
        self.receive = if u16::from(self.receive) > PASSIVE {
            AFTER_GOOD_FRAME
        } else {
            self.receive.saturating_sub(1)
        };
    }

    /// Counts a failed frame of another station; `is_first` if this station sent the first error
    /// flag.
    pub fn receive_failed(&mut self, is_first: bool) {
        self.receive = self.receive.saturating_add(if is_first { 8 } else { 1 });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lone_sender_stops_at_error_passive() {
        let mut counters = ErrorCounters::default();
        for _ in 0..16 {
            counters.send_failed(true);
        }
        assert_eq!(
            (counters.transmit(), counters.state()),
            (128, ErrorState::Passive)
        );
        counters.send_failed(true);
        assert_eq!(counters.transmit(), 128);
    }

    #[test]
    fn thirty_two_failed_frames_cause_bus_off() {
        let mut counters = ErrorCounters::default();
        for sent in 0..32 {
            assert_ne!(counters.state(), ErrorState::BusOff, "after {sent}");
            counters.send_failed(false);
        }
        assert_eq!(counters.state(), ErrorState::BusOff);
        assert_eq!(counters.transmit(), 255);
    }

    #[test]
    fn a_good_frame_compensates_an_eighth_of_a_failed_one() {
        let mut counters = ErrorCounters::default();
        counters.send_failed(false);
        counters.sent();
        assert_eq!(counters.transmit(), 7);
    }

    #[test]
    fn a_receiver_warns_at_96_is_passive_above_127_and_returns_to_120() {
        let mut counters = ErrorCounters::default();
        for _ in 0..12 {
            counters.receive_failed(true);
        }
        assert!(counters.is_warning());
        assert_eq!(counters.state(), ErrorState::Active);
        for _ in 0..32 {
            counters.receive_failed(false);
        }
        assert_eq!(counters.state(), ErrorState::Passive);
        counters.received();
        assert_eq!(
            (counters.receive(), counters.state()),
            (120, ErrorState::Active)
        );
    }
}
