//! Text in an array of fixed size, terminated by a zero.

use core::ffi::c_char;
use core::fmt;

/// Text of fewer than `N` bytes; the rest is zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Text<const N: usize>(pub [c_char; N]);

impl<const N: usize> Default for Text<N> {
    fn default() -> Self {
        Self([0; N])
    }
}

impl<const N: usize> fmt::Write for Text<N> {
    /// Appends as much as fits before the last zero; fails if that is not all. A character of
    /// several bytes is not split.
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let used = self.0.iter().take_while(|c| **c != 0).count();
        let free = self.0.iter_mut().skip(used);
        let room = free.len().saturating_sub(1);
        let end = text.floor_char_boundary(room);
        for (place, byte) in free.zip(text.as_bytes().iter().take(end)) {
            *place = byte.cast_signed() as c_char;
        }
        if end == text.len() {
            Ok(())
        } else {
            Err(fmt::Error)
        }
    }
}

/// The text as an array, truncated if it is too long.
pub fn fixed<const N: usize>(text: &str) -> [c_char; N] {
    let mut result = Text::default();
    // Truncation is not an error here: a test shows that every text of the library fits.
    let _ = fmt::Write::write_str(&mut result, text);
    result.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::fmt::Write;

    fn bytes<const N: usize>(text: [c_char; N]) -> [u8; N] {
        text.map(|c| c as u8)
    }

    #[test]
    fn text_that_is_too_long_is_truncated_and_ends_in_a_zero() {
        let mut text = Text::<4>::default();
        assert!(write!(text, "ab").is_ok());
        assert!(write!(text, "cd").is_err());
        assert_eq!(&bytes(text.0), b"abc\0");
        assert!(write!(text, "e").is_err());
        assert_eq!(&bytes(text.0), b"abc\0");
    }

    #[test]
    fn a_character_is_not_split() {
        assert_eq!(&bytes(fixed::<4>("ab\u{b5}")), b"ab\0\0");
    }

    #[test]
    fn an_empty_array_holds_no_text() {
        assert!(fixed::<0>("a").is_empty());
    }
}
