//! Arbitration, acknowledgement and error frames of one frame (ISO 11898-1).

use rigless::chip::can::{ERROR_DELIMITER_BITS, ERROR_FLAG_BITS, INTERMISSION_BITS, SUSPEND_BITS};

use super::super::{BitTiming, ErrorState, Frame};
use super::WireFault;

/// A station at the start of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Station {
    /// Its bit timing.
    pub timing: BitTiming,
    /// Its error state; a bus-off station does not take part.
    pub state: ErrorState,
    /// Frame that it has to transmit.
    pub offer: Option<Frame>,
    /// Silent mode: it neither acknowledges nor signals errors.
    pub is_silent: bool,
    /// Whether its frames need an acknowledgement; false in loop-back mode.
    pub needs_acknowledge: bool,
}

/// Outcome of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Another station acknowledged it.
    Delivered,
    /// No station acknowledged it.
    Unacknowledged,
    /// An error flag destroyed it: of this station, whose bit timing differs, or because of a
    /// disturbance at all stations.
    Disturbed(Option<usize>),
    /// Bit error: the transmitter did not read back its own dominant bit.
    BitError,
}

/// A frame in transmission.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Transfer {
    /// Index of the transmitter.
    pub sender: usize,
    /// Its frame.
    pub frame: Frame,
    /// Its bit timing.
    pub timing: BitTiming,
    /// Its outcome.
    pub outcome: Outcome,
    suspended: bool,
}

/// Bits until a station with a different bit timing detects a stuff error: six bits at half the
/// rate.
const BITS_TO_STUFF_ERROR: u32 = 12;

impl Transfer {
    /// Whether a station that only listens receives the whole frame: one without an acknowledgement
    /// is destroyed by the error flag of its transmitter, unless that is error-passive and its flag
    /// recessive.
    pub fn is_whole(&self) -> bool {
        match self.outcome {
            Outcome::Delivered => true,
            Outcome::Unacknowledged => self.suspended,
            Outcome::Disturbed(_) | Outcome::BitError => false,
        }
    }

    fn outcome_bits(&self) -> u32 {
        let error_frame = ERROR_FLAG_BITS + ERROR_DELIMITER_BITS;
        match self.outcome {
            Outcome::Delivered => self.frame.bits_on_the_wire(),
            Outcome::Unacknowledged => self.frame.bits_through_acknowledge() + error_frame,
            Outcome::Disturbed(_) => BITS_TO_STUFF_ERROR + error_frame,
            Outcome::BitError => 1 + error_frame,
        }
    }

    /// Time from the start of the frame until its outcome is determined, ns.
    pub fn outcome_ns(&self) -> u64 {
        self.timing.bits_ns(self.outcome_bits())
    }

    /// Time from the start of the frame until the next one may start, ns.
    pub(super) fn busy_ns(&self) -> u64 {
        let failed = self.outcome != Outcome::Delivered;
        let suspend = if failed && self.suspended {
            SUSPEND_BITS
        } else {
            0
        };
        (self.timing).bits_ns(self.outcome_bits() + INTERMISSION_BITS + suspend)
    }
}

/// Arbitrates between these stations; `None` if none has a frame to transmit. A station that is not
/// on the bus is `None`.
pub fn arbitrate(
    stations: &[Option<Station>],
    fault: WireFault,
    is_disturbed: bool,
) -> Option<Transfer> {
    let present = || {
        (stations.iter().enumerate())
            .filter_map(|(index, station)| station.as_ref().map(|station| (index, station)))
    };
    let (sender, station, frame) = present()
        .filter_map(|(index, station)| station.offer.map(|frame| (index, station, frame)))
        .min_by(|(_, _, a), (_, _, b)| a.arbitrates(b))?;
    let others = || present().filter(|(index, _)| *index != sender);
    let collides = others().any(|(_, other)| {
        let equal = |offer: &Frame| offer.arbitrates(&frame).is_eq() && *offer != frame;
        other.offer.as_ref().is_some_and(equal)
    });
    let other_rate = others().find(|(_, other)| {
        !other.is_silent
            && other.state == ErrorState::Active
            && !other.timing.is_compatible(&station.timing)
    });
    let is_acknowledged =
        others().any(|(_, other)| !other.is_silent && other.timing.is_compatible(&station.timing));
    let outcome = if fault == WireFault::Short {
        Outcome::BitError
    } else if is_disturbed || collides {
        Outcome::Disturbed(None)
    } else if let Some((index, _)) = other_rate {
        Outcome::Disturbed(Some(index))
    } else if is_acknowledged || !station.needs_acknowledge {
        Outcome::Delivered
    } else {
        Outcome::Unacknowledged
    };
    Some(Transfer {
        sender,
        frame,
        timing: station.timing,
        outcome,
        suspended: station.state == ErrorState::Passive,
    })
}
