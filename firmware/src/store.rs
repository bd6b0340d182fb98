//! Parameters in flash; a loss of power at any moment leaves the previous or the new set.
//!
//! Two pages are written in turn. A page holds one set:
//!
//! | offset | word |
//! |---|---|
//! | 0 | hash of the layout, [`layout_hash`] |
//! | 4 | sequence number, one more than that of the other page |
//! | 8 | the set |
//! | last word | CRC-32 (ISO-HDLC) of all words before it, little endian |
//!
//! A save erases the page that does not hold the newest set, writes the words in order, the CRC
//! last, and reads all of them back. The page is invalid until its CRC is complete, and the other
//! page is unchanged. Words and pages that a loss of power left half written or half erased fail
//! the CRC.
//!
//! The layout hash covers name and type of every word in order. A page whose layout differs, as
//! after an update of the program with other parameters, is refused like a corrupt page: the
//! defaults are used and the origin is [`Origin::DefaultsInsteadOfCorrupt`]. It has no origin of
//! its own, because a damaged hash looks the same and the remedy is the same: check the
//! parameters and save them again.
//!
//! [`load`] reads both pages at start-up; [`Saver`] writes one, a row of the flash in each call: a
//! word, or as many words as the flash writes together, the last row filled with erased words.

mod flash;
mod layout;
mod page;
mod saver;
#[cfg(test)]
mod tests;

pub use flash::{Flash, MAX_ROW, Page, Status};
pub use layout::{Field, layout_hash};
pub use saver::{Progress, SaveError, Saver};

use core::fmt::Debug;

use page::{Content, Image};

/// A set of values that is stored in a page.
pub trait Stored: Copy + PartialEq + Debug {
    /// The hash of its layout, the first word of a page.
    const LAYOUT: u32;

    /// The set that is used without a stored one.
    const DEFAULT: Self;

    /// All words of a page: [`EDGES`] more than the set has.
    type Page: Copy + Eq + Debug + AsRef<[u32]> + AsMut<[u32]>;

    /// A page of zeros.
    const ZEROS: Self::Page;

    /// Writes the words of the set.
    fn write(&self, words: &mut [u32]);

    /// The set of these words; `None` if they are no valid set.
    fn read(words: &[u32]) -> Option<Self>;
}

/// Words of a page in addition to the set: layout hash, sequence number and CRC.
pub const EDGES: usize = 3;

/// What the flash holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Loaded<S> {
    /// The newest valid set, or the defaults.
    pub parameters: S,
    /// Where they come from.
    pub origin: Origin,
    newest: Option<Newest>,
}

/// Where the newest set is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Newest {
    page: Page,
    sequence: u32,
}

/// Where parameters come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// The flash.
    Stored,
    /// The flash is blank: no set has been stored.
    Defaults,
    /// The flash is not empty, but holds no valid set of this layout: the defaults are used.
    DefaultsInsteadOfCorrupt,
}

/// The words of the first page after the first save: a programmer can write them, and the board
/// starts with this set.
#[must_use]
pub fn first_page<S: Stored>(set: &S) -> S::Page {
    let mut image = Image::blank();
    image.fill(1, set);
    image.into_words()
}

/// Reads the newest valid set. Must not be called while the flash is busy.
pub fn load<S: Stored>(flash: &impl Flash) -> Loaded<S> {
    let content = |page| Image::<S>::read(flash, page).content();
    let pages = (content(Page::First), content(Page::Second));
    let newest = match pages {
        (Content::Valid(a), Content::Valid(b)) if is_newer(b, a) => Some((Page::Second, b)),
        (Content::Valid(sequence), _) => Some((Page::First, sequence)),
        (_, Content::Valid(sequence)) => Some((Page::Second, sequence)),
        _ => None,
    };
    let stored = newest.and_then(|(page, _)| Image::<S>::read(flash, page).set());
    Loaded {
        parameters: stored.unwrap_or(S::DEFAULT),
        origin: match pages {
            _ if stored.is_some() => Origin::Stored,
            // The very first save may have been cut off by a loss of power.
            (Content::Empty | Content::Unfinished, Content::Empty) => Origin::Defaults,
            _ => Origin::DefaultsInsteadOfCorrupt,
        },
        newest: newest.map(|(page, sequence)| Newest { page, sequence }),
    }
}

/// Whether a sequence number comes after another; they wrap.
fn is_newer(a: u32, b: u32) -> bool {
    a != b && a.wrapping_sub(b) < 1 << 31
}
