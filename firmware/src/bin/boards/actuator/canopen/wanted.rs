//! The identifiers of the frames that concern the node, from the node to the interrupts of the bus.

use embedded_can::{Id, StandardId};
use firmware::drive::{RPDOS, TPDOS};

use crate::actuator::can_filters;

/// As many as there can be.
const MOST: usize = canopen::SERVICE_IDENTIFIERS + RPDOS + TPDOS;
const _: () = assert!(MOST <= can_filters::MOST);

/// A list of identifiers, and whether of remote frames.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Wanted {
    list: [(Id, bool); MOST],
    count: usize,
}

impl Wanted {
    /// All of these.
    pub fn of(identifiers: impl Iterator<Item = (Id, bool)>) -> Self {
        let mut wanted = Self {
            list: [(Id::Standard(StandardId::ZERO), false); MOST],
            count: 0,
        };
        for (place, identifier) in wanted.list.iter_mut().zip(identifiers) {
            *place = identifier;
            wanted.count += 1;
        }
        wanted
    }

    /// One after the other.
    pub fn iter(&self) -> impl Iterator<Item = (Id, bool)> {
        self.list.iter().take(self.count).copied()
    }
}
