//! The state of an update, as it is written to the log.
//!
//! | word | content |
//! |---|---|
//! | 0 | sequence number |
//! | 1 | phase, starts of a trial, outcome; 0 |
//! | 2 | latest confirmed version |
//! | 3 | identity of the image to be installed |
//! | 4 | identity of the image in the backup |
//! | 5 | [`FORMAT`] |
//! | 6 | node-ID, 0, bit rate in kbit/s |
//! | 7 | CRC-32 of the words before it |

use canopen::BitRate;

use crate::header::{CRC, Version};

/// Words of a record.
pub(crate) const WORDS: usize = 8;

/// Bytes of a record.
pub(crate) const SIZE: u32 = 4 * WORDS as u32;

/// Offset of the format in a record, bytes.
pub(crate) const FORMAT_OFFSET: u32 = 20;

/// Format of a record.
pub(crate) const FORMAT: u32 = u32::from_le_bytes(*b"SAR1");

/// What is to be done at the next start.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Phase {
    /// Run the slot.
    Idle = 0,
    /// Check the staged image, and copy the slot to the backup.
    Backup = 1,
    /// Copy the staged image to the slot.
    Install = 2,
    /// Run the slot, which is not confirmed yet.
    Trial = 3,
    /// Copy the backup to the slot.
    Restore = 4,
}

/// How the last update ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Outcome {
    /// There was none.
    None = 0,
    /// The new image was confirmed.
    Confirmed = 1,
    /// It was not confirmed: the image before runs again.
    RolledBack = 2,
    /// It was refused before anything was changed.
    Refused = 3,
    /// Neither the new image nor the one before could be installed.
    Failed = 4,
}

/// The state of an update.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct State {
    /// What is to be done.
    pub phase: Phase,
    /// Starts of a trial.
    pub starts: u8,
    /// How the last update ended.
    pub outcome: Outcome,
    /// The latest version that was confirmed: no earlier one is installed.
    pub floor: Version,
    /// [`Header::identity`](crate::Header::identity) of the image to be installed, or that was
    /// installed last; 0 for none.
    pub image: u32,
    /// The same of the image in the backup.
    pub backup: u32,
    /// Node-ID and bit rate of the bootloader, which the program copies from its parameters: they
    /// are where the bootloader of any version finds them.
    pub bus: Bus,
}

/// Node-ID and bit rate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bus {
    /// Node-ID, 1 to 127.
    pub node_id: u8,
    /// Bit rate, kbit/s.
    pub kbit_s: u16,
}

impl Bus {
    /// The factory settings of the actuator.
    pub const DEFAULT: Self = Self {
        node_id: 1,
        kbit_s: 1000,
    };

    /// A bit rate of the actuator board, kbit/s.
    ///
    /// ```
    /// use bootloader::Bus;
    /// use canopen::BitRate;
    ///
    /// assert_eq!(Bus::kbit_s_of(BitRate::Kbit250), Some(250));
    /// ```
    #[must_use]
    pub const fn kbit_s_of(bit_rate: BitRate) -> Option<u16> {
        match bit_rate {
            BitRate::Kbit1000 => Some(1000),
            BitRate::Kbit500 => Some(500),
            BitRate::Kbit250 => Some(250),
            BitRate::Kbit125 => Some(125),
            // The CAN controller's clock of 42 MHz is no multiple of 800 kHz; telemetry at 250 Hz
            // takes 100 kbit/s.
            _ => None,
        }
    }

    const fn word(self) -> u32 {
        (self.kbit_s as u32) << 16 | self.node_id as u32
    }

    const fn of_word(word: u32) -> Self {
        Self {
            node_id: word as u8,
            kbit_s: (word >> 16) as u16,
        }
    }
}

impl State {
    /// The state without any record.
    pub const FIRST: Self = Self {
        phase: Phase::Idle,
        starts: 0,
        outcome: Outcome::None,
        floor: Version(0),
        image: 0,
        backup: 0,
        bus: Bus::DEFAULT,
    };

    /// The request to install the staged image of this identity.
    ///
    /// ```
    /// use bootloader::{Phase, State};
    ///
    /// assert_eq!(State::FIRST.request(7).phase, Phase::Backup);
    /// ```
    #[must_use]
    pub const fn request(self, image: u32) -> Self {
        Self {
            phase: Phase::Backup,
            starts: 0,
            image,
            ..self
        }
    }

    /// The image in the slot has shown that it works: it has this version.
    #[must_use]
    pub const fn confirm(self, version: Version) -> Self {
        Self {
            phase: Phase::Idle,
            starts: 0,
            outcome: Outcome::Confirmed,
            floor: version,
            ..self
        }
    }

    pub(crate) const fn with_phase(self, phase: Phase) -> Self {
        Self { phase, ..self }
    }

    pub(crate) const fn ended(self, outcome: Outcome) -> Self {
        Self {
            phase: Phase::Idle,
            starts: 0,
            outcome,
            ..self
        }
    }

    /// The words of a record of this state.
    pub fn words(&self, sequence: u32) -> [u32; WORDS] {
        let kind = [self.phase as u8, self.starts, self.outcome as u8, 0];
        let content = [
            sequence,
            u32::from_le_bytes(kind),
            self.floor.0,
            self.image,
            self.backup,
            FORMAT,
            self.bus.word(),
        ];
        let [a, b, c, d, e, f, g] = content;
        [a, b, c, d, e, f, g, checksum(content)]
    }

    /// Sequence number and state of a record; `None` if it is damaged, or none.
    pub fn read(words: [u32; WORDS]) -> Option<(u32, Self)> {
        let [sequence, kind, floor, image, backup, format, bus, crc] = words;
        let content = [sequence, kind, floor, image, backup, format, bus];
        if format != FORMAT || crc != checksum(content) {
            return None;
        }
        let [phase, starts, outcome, _] = kind.to_le_bytes();
        let state = Self {
            phase: match phase {
                0 => Phase::Idle,
                1 => Phase::Backup,
                2 => Phase::Install,
                3 => Phase::Trial,
                4 => Phase::Restore,
                _ => return None,
            },
            starts,
            outcome: match outcome {
                0 => Outcome::None,
                1 => Outcome::Confirmed,
                2 => Outcome::RolledBack,
                3 => Outcome::Refused,
                4 => Outcome::Failed,
                _ => return None,
            },
            floor: Version(floor),
            image,
            backup,
            bus: Bus::of_word(bus),
        };
        Some((sequence, state))
    }
}

fn checksum(content: [u32; WORDS - 1]) -> u32 {
    let mut digest = CRC.digest();
    for word in content {
        digest.update(&word.to_le_bytes());
    }
    digest.finalize()
}
