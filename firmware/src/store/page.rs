//! The content of a page.

use crc::{CRC_32_ISO_HDLC, Crc, NoTable};

use super::{Flash, Page};
use crate::parameters::{BoardParameters, WORDS};

/// "SA", and the version of the layout: one more with each change of the parameters' words.
pub(super) const MAGIC: u32 = 0x5341_0001;

/// Words in front of the parameters: magic and sequence number.
const HEAD: usize = 2;

/// Words of a page, the CRC being the last.
pub(super) const PAGE_WORDS: usize = HEAD + WORDS + 1;

/// Bit by bit: a table would take 1 KiB, and a page is hashed in 15,000 instructions when the board
/// starts or saves, away from the control step.
const CRC: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);

/// What a page holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Content {
    /// Nothing: as after an erase.
    Empty,
    /// A set of parameters that was not written to its end: its CRC is missing.
    Unfinished,
    /// A set of parameters with this sequence number.
    Valid(u32),
    /// Anything else.
    Corrupt,
}

/// The words of a page.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Image([u32; PAGE_WORDS]);

impl Image {
    /// A set of parameters.
    pub fn new(sequence: u32, parameters: &BoardParameters) -> Self {
        let mut words = [0; PAGE_WORDS];
        let content = [MAGIC, sequence].into_iter().chain(parameters.words());
        for (word, content) in words.iter_mut().zip(content) {
            *word = content;
        }
        let [content @ .., check] = &mut words;
        *check = checksum(content);
        Self(words)
    }

    /// What a page of the flash holds.
    pub fn read(flash: &impl Flash, page: Page) -> Self {
        let mut words = [0; PAGE_WORDS];
        for (offset, word) in (0..).step_by(4).zip(&mut words) {
            *word = flash.read(page, offset);
        }
        Self(words)
    }

    /// The word of this index; `None` behind the last one.
    pub fn word(&self, index: u16) -> Option<u32> {
        self.0.get(usize::from(index)).copied()
    }

    /// Whether that is a set of parameters.
    pub fn content(&self) -> Content {
        let [covered @ .., check] = &self.0;
        let &[_, sequence, ..] = covered;
        if self.0.iter().all(|&word| word == u32::MAX) {
            Content::Empty
        } else if checksum(covered) == *check && self.parameters().is_some() {
            Content::Valid(sequence)
        } else if *check == u32::MAX {
            Content::Unfinished
        } else {
            Content::Corrupt
        }
    }

    /// The parameters, if they are of this layout and possible; the CRC is not looked at.
    pub fn parameters(&self) -> Option<BoardParameters> {
        match &self.0 {
            [MAGIC, _, parameters @ .., _] => BoardParameters::from_words(parameters),
            _ => None,
        }
    }
}

fn checksum(words: &[u32]) -> u32 {
    let mut digest = CRC.digest();
    for word in words {
        digest.update(&word.to_le_bytes());
    }
    digest.finalize()
}
