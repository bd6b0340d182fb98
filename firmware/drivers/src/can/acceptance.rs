//! The list of the identifiers that a node receives.

use embedded_can::{ExtendedId, Id, StandardId};
use firmware::drive::{Device, RPDOS, TPDOS};

/// Bits of a word that give the kind of the frame.
const REMOTE: u32 = 1 << 1;
const EXTENDED: u32 = 1 << 2;

/// Identifiers of the frames that the node receives.
#[derive(Debug)]
pub struct AcceptedIds {
    words: [u32; Self::MAXIMUM],
    count: usize,
    /// Every other word is the mask of the one before.
    has_masks: bool,
}

impl AcceptedIds {
    /// Maximum number of identifiers that a node receives.
    pub const MAXIMUM: usize = canopen::SERVICE_IDENTIFIERS + RPDOS + TPDOS;

    /// The list of these identifiers, each with whether of remote frames.
    pub fn new(identifiers: impl Iterator<Item = (Id, bool)>) -> Self {
        let mut accepted = Self {
            words: [0; Self::MAXIMUM],
            count: 0,
            has_masks: false,
        };
        for (word, identifier) in accepted.words.iter_mut().zip(identifiers) {
            *word = filter_word(identifier);
            accepted.count += 1;
        }
        accepted
    }

    /// What a device receives: a list of identifiers with CANopen, identifiers and masks with
    /// DroneCAN.
    pub fn of(device: &Device<'_>) -> Self {
        let Some(node) = device.dronecan() else {
            return Self::new(device.node().identifiers());
        };
        let pairs = node.filters().into_iter().flat_map(|(id, mask)| {
            let mask = ExtendedId::new(mask).unwrap_or(ExtendedId::MAX);
            // The mask compares the kind of the frame too.
            [(Id::Extended(id), false), (Id::Extended(mask), true)]
        });
        Self {
            has_masks: true,
            ..Self::new(pairs)
        }
    }

    /// Whether every other word is a mask; this remains until a restart.
    pub fn has_masks(&self) -> bool {
        self.has_masks
    }

    /// A word for each identifier, as a filter of bxCAN in list mode has it (RM0090, figure 342):
    /// the identifier from bit 21 on, or an extended one from bit 3 on; the kind of the frame.
    pub fn words(&self) -> impl Iterator<Item = u32> + Clone {
        self.words.iter().take(self.count).copied()
    }

    /// The identifiers, each with whether of remote frames.
    ///
    /// ```
    /// use drivers::can::AcceptedIds;
    /// use embedded_can::{ExtendedId, Id, StandardId};
    /// let ids = [
    ///     (Id::Standard(StandardId::MAX), false),
    ///     (Id::Extended(ExtendedId::new(0x1234_5678).unwrap()), true),
    /// ];
    /// assert!(AcceptedIds::new(ids.into_iter()).identifiers().eq(ids));
    /// ```
    pub fn identifiers(&self) -> impl Iterator<Item = (Id, bool)> + Clone {
        self.words().map(|word| {
            let id = if word & EXTENDED != 0 {
                Id::Extended(ExtendedId::new(word >> 3).unwrap_or(ExtendedId::ZERO))
            } else {
                Id::Standard(StandardId::new((word >> 21) as u16).unwrap_or(StandardId::ZERO))
            };
            (id, word & REMOTE != 0)
        })
    }
}

/// The 32-bit word of an identifier.
fn filter_word((id, is_remote): (Id, bool)) -> u32 {
    let kind = if is_remote { REMOTE } else { 0 };
    kind | match id {
        Id::Standard(id) => u32::from(id.as_raw()) << 21,
        Id::Extended(id) => id.as_raw() << 3 | EXTENDED,
    }
}
