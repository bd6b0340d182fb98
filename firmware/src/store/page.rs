//! The content of a page.

use crc::{CRC_32_ISO_HDLC, Crc, NoTable};

use super::{EDGES, Flash, Page, Stored};
use crate::parameters::{BoardParameters, WORDS};

/// Words in front of the set: magic and sequence number.
const HEAD: usize = 2;

/// Words of a page of parameters, the CRC being the last.
pub(super) const PAGE_WORDS: usize = WORDS + EDGES;

impl Stored for BoardParameters {
    /// "SA", and the version of the layout: one more with each change of the parameters' words.
    const MAGIC: u32 = 0x5341_0002;
    const DEFAULT: Self = Self::DEFAULT;
    type Page = [u32; PAGE_WORDS];
    const ZEROS: Self::Page = [0; PAGE_WORDS];

    fn write(&self, words: &mut [u32]) {
        for (number, word) in (0..).zip(words) {
            *word = self.word(number).unwrap_or(0);
        }
    }

    fn read(words: &[u32]) -> Option<Self> {
        Self::from_words(words.first_chunk()?)
    }
}

/// Bit by bit: a table would take 1 KiB, and a word is hashed in some 250 instructions when the
/// board starts or saves, away from the control step.
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

/// Offsets of words, bytes.
pub(super) fn offsets() -> impl Iterator<Item = u16> {
    (0..).step_by(4)
}

/// The words of a page.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Image<S: Stored>(S::Page);

impl<S: Stored> Image<S> {
    /// Nothing yet.
    pub const fn blank() -> Self {
        Self(S::ZEROS)
    }

    /// Becomes this set's; where it is, for it is large.
    pub fn fill(&mut self, sequence: u32, set: &S) {
        let page = self.0.as_mut();
        if let [magic, number, content @ .., _] = page {
            (*magic, *number) = (S::MAGIC, sequence);
            set.write(content);
        }
        if let [covered @ .., check] = page {
            *check = checksum(covered);
        }
    }

    /// Whether a page of the flash holds it, word for word.
    pub fn is_in(&self, flash: &impl Flash, page: Page) -> bool {
        let words = self.0.as_ref().iter().zip(offsets());
        words
            .into_iter()
            .all(|(word, offset)| flash.read(page, offset) == *word)
    }

    /// The words.
    pub fn into_words(self) -> S::Page {
        self.0
    }

    /// What a page of the flash holds.
    pub fn read(flash: &impl Flash, page: Page) -> Self {
        let mut words = S::ZEROS;
        for (offset, word) in offsets().zip(words.as_mut()) {
            *word = flash.read(page, offset);
        }
        Self(words)
    }

    /// The word of this index; `None` behind the last one.
    pub fn word(&self, index: u16) -> Option<u32> {
        self.0.as_ref().get(usize::from(index)).copied()
    }

    /// Whether that is a set.
    pub fn content(&self) -> Content {
        let [covered @ .., check] = self.0.as_ref() else {
            return Content::Corrupt;
        };
        if self.0.as_ref().iter().all(|&word| word == u32::MAX) {
            Content::Empty
        } else if checksum(covered) == *check && self.set().is_some() {
            Content::Valid(covered.get(1).copied().unwrap_or(0))
        } else if *check == u32::MAX {
            Content::Unfinished
        } else {
            Content::Corrupt
        }
    }

    /// The set, if it is of this layout and possible; the CRC is not looked at.
    pub fn set(&self) -> Option<S> {
        let [content @ .., _] = self.0.as_ref() else {
            return None;
        };
        let (head, content) = content.split_at_checked(HEAD)?;
        (head.first() == Some(&S::MAGIC))
            .then(|| S::read(content))
            .flatten()
    }
}

fn checksum(words: &[u32]) -> u32 {
    let mut digest = CRC.digest();
    for word in words {
        digest.update(&word.to_le_bytes());
    }
    digest.finalize()
}
