//! The content of a page.

use super::{Flash, MAX_ROW, Page, Stored};
use crc::{CRC_32_ISO_HDLC, Crc, NoTable};

/// Words before the set: layout hash and sequence number.
const HEAD: usize = 2;

/// What a page holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Content {
    /// Nothing: erased.
    Empty,
    /// The beginning of a set: its save was cut off before the CRC.
    Unfinished,
    /// A set with this sequence number.
    Valid(u32),
    /// Anything else, also a set of another layout.
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
    /// A page of zeros.
    pub const fn blank() -> Self {
        Self(S::ZEROS)
    }

    /// Fills the page with a set, in place because it is large.
    pub fn fill(&mut self, sequence: u32, set: &S) {
        let page = self.0.as_mut();
        if let [layout, number, content @ .., _] = page {
            (*layout, *number) = (S::LAYOUT, sequence);
            set.write(content);
        }
        if let [covered @ .., check] = page {
            *check = checksum(covered);
        }
    }

    /// Whether a page of the flash holds these words.
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

    /// Reads a page of the flash.
    pub fn read(flash: &impl Flash, page: Page) -> Self {
        let mut words = S::ZEROS;
        for (offset, word) in offsets().zip(words.as_mut()) {
            *word = flash.read(page, offset);
        }
        Self(words)
    }

    /// The longest row of words from this index on, filled with erased words; `None` after the last
    /// word.
    pub fn row(&self, index: u16) -> Option<[u32; MAX_ROW]> {
        let words = self.0.as_ref().get(usize::from(index)..)?;
        let mut row = [u32::MAX; MAX_ROW];
        row.iter_mut()
            .zip(words)
            .for_each(|(place, word)| *place = *word);
        (!words.is_empty()).then_some(row)
    }

    /// What the page holds.
    pub fn content(&self) -> Content {
        let words = self.0.as_ref();
        let [covered @ .., check] = words else {
            return Content::Corrupt;
        };
        if is_erased(words) {
            Content::Empty
        } else if checksum(covered) == *check && self.set().is_some() {
            Content::Valid(covered.get(1).copied().unwrap_or(0))
        } else if *check == u32::MAX && self.begins_with_layout() {
            Content::Unfinished
        } else {
            Content::Corrupt
        }
    }

    /// Whether the first word is the layout hash, or part of it in a page that is otherwise erased:
    /// writing clears bits, so that a word that was cut off has all set bits of the hash.
    fn begins_with_layout(&self) -> bool {
        match self.0.as_ref() {
            [layout, _, ..] if *layout == S::LAYOUT => true,
            [layout, rest @ ..] => layout & S::LAYOUT == S::LAYOUT && is_erased(rest),
            [] => false,
        }
    }

    /// The set, if it has this layout and is valid; the CRC is not checked.
    pub fn set(&self) -> Option<S> {
        let [content @ .., _] = self.0.as_ref() else {
            return None;
        };
        let (head, content) = content.split_at_checked(HEAD)?;
        (head.first() == Some(&S::LAYOUT))
            .then(|| S::read(content))
            .flatten()
    }
}

fn is_erased(words: &[u32]) -> bool {
    words.iter().all(|&word| word == u32::MAX)
}

/// Bit by bit: a word takes about 250 instructions, in a save and at the start only.
fn checksum(words: &[u32]) -> u32 {
    const CRC: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);
    let mut digest = CRC.digest();
    for word in words {
        digest.update(&word.to_le_bytes());
    }
    digest.finalize()
}
