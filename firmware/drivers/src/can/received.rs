//! A received frame that shows whether it has changed since its reception.

use canopen::CanFrame;

use super::{CanPort, FrameWords};

/// A received frame, as its controller holds it, with a check value.
#[derive(Clone, Copy, Debug)]
pub struct ReceivedFrame {
    words: FrameWords,
    check: u32,
}

impl ReceivedFrame {
    /// A frame, with the check value of a second reading.
    #[must_use]
    #[inline]
    pub fn new(words: FrameWords, again: FrameWords) -> Self {
        Self {
            words,
            check: check(again),
        }
    }

    /// The frame from a controller of this type, if both readings were the same and it has not
    /// changed since.
    #[must_use]
    #[inline]
    pub fn intact<P: CanPort>(&self) -> Option<CanFrame> {
        (check(self.words) == self.check).then(|| self.unchecked::<P>())
    }

    /// The frame as it is, from a controller of this type.
    #[must_use]
    #[inline]
    pub fn unchecked<P: CanPort>(&self) -> CanFrame {
        P::frame(&self.words)
    }
}

/// Each word is added without carry to the sum rotated by five bits: a change within one word
/// always changes the sum.
#[inline]
fn check(words: FrameWords) -> u32 {
    (words.iter()).fold(!0, |sum: u32, word| sum.rotate_left(5) ^ word)
}
