//! Parameters in flash, so that a loss of power at any moment leaves the old set or the new one.
//!
//! Two pages take turns. A page holds one set:
//!
//! | offset | word |
//! |---|---|
//! | 0 | magic and version of the layout |
//! | 4 | sequence number, one more than that of the other page |
//! | 8 | the parameters |
//! | behind them | CRC-32 (ISO-HDLC) of all words before, their bytes little endian |
//!
//! A save erases the page that does not hold the newest set, then writes the words in order, the
//! CRC last, then reads all of it back. Until the CRC stands, the page is not valid, and the other
//! one is as it was. Whatever a page holds after a loss of power, it is valid only if its CRC is;
//! half-written words and half-erased pages fail it as they would any page.
//!
//! [`load`] reads both pages when the board starts; [`Saver`] writes one, a word in each call.

mod flash;
mod page;
mod saver;
#[cfg(test)]
mod tests;

pub use flash::{Flash, Page, Status};
pub use saver::{Progress, SaveError, Saver};

use core::fmt::Debug;

use crate::parameters::BoardParameters;
use page::{Content, Image};

/// A set of values that a page keeps.
pub trait Stored: Copy + PartialEq + Debug {
    /// What a page of it begins with: what it is, and the version of its layout.
    const MAGIC: u32;

    /// What serves where nothing is stored.
    const DEFAULT: Self;

    /// All words of a page: [`EDGES`] more than the set has.
    type Page: Copy + Eq + Debug + AsRef<[u32]> + AsMut<[u32]>;

    /// A page of zeros.
    const ZEROS: Self::Page;

    /// Writes the set's words.
    fn write(&self, words: &mut [u32]);

    /// The set of these words; `None` where it is not possible as a whole.
    fn read(words: &[u32]) -> Option<Self>;
}

/// Words of a page beside its set: magic, sequence number and CRC.
pub const EDGES: usize = 3;

/// What the flash holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Loaded<S = BoardParameters> {
    /// The newest set that is valid, or the defaults.
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
    /// The flash is empty: nothing was ever stored.
    Defaults,
    /// The flash holds something, but no valid set: the defaults serve.
    DefaultsInsteadOfCorrupt,
}

/// Reads the newest valid set.
///
/// Call it while the flash is not busy.
pub fn load(flash: &impl Flash) -> Loaded {
    load_set(flash)
}

/// The words with which the first page begins once a set has been saved for the first time: a programmer can put them
/// there, and the board starts with that set.
///
/// ```
/// use firmware::{parameters::BoardParameters, store};
/// struct Flash(Vec<u32>);
/// impl store::Flash for Flash {
///     fn start_erase(&mut self, _: store::Page) {}
///     fn start_program(&mut self, _: store::Page, _: u16, _: u32) {}
///     fn status(&mut self) -> store::Status { store::Status::Ready }
///     fn read(&self, page: store::Page, offset: u16) -> u32 {
///         let words = if page == store::Page::First { self.0.as_slice() } else { &[] };
///         words.get(usize::from(offset / 4)).copied().unwrap_or(u32::MAX)
///     }
/// }
/// let mut parameters = BoardParameters::DEFAULT;
/// parameters.bus.node_id = 42;
/// let flash = Flash(store::first_page(&parameters).to_vec());
/// assert_eq!(store::load(&flash).parameters.bus.node_id, 42);
/// ```
#[must_use]
pub fn first_page<S: Stored>(set: &S) -> S::Page {
    let mut image = Image::blank();
    image.fill(1, set);
    image.into_words()
}

/// As [`load`], of any kind of set.
pub fn load_set<S: Stored>(flash: &impl Flash) -> Loaded<S> {
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
            // The first save of all may have lost its power.
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
