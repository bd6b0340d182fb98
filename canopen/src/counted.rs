//! Values of which an owner can tell whether they may have changed.

use core::ops::{Deref, DerefMut};

/// A value, and the number of mutable accesses to it.
///
/// A checksum of the value that was computed at the same number of accesses is that of the present
/// value, unless the memory has changed by itself.
///
/// ```
/// let mut value = canopen::Counted::new(7);
/// assert_eq!((*value, value.accesses()), (7, 0));
/// *value = 8;
/// assert_eq!((*value, value.accesses()), (8, 1));
/// ```
#[derive(Debug)]
pub struct Counted<T> {
    value: T,
    accesses: u32,
}

impl<T> Counted<T> {
    /// A value without accesses.
    pub const fn new(value: T) -> Self {
        Self { value, accesses: 0 }
    }

    /// Number of mutable accesses, modulo 2^32. As long as it is the same, each byte of the value
    /// is the same.
    pub const fn accesses(&self) -> u32 {
        self.accesses
    }
}

impl<T> Deref for Counted<T> {
    type Target = T;

    #[inline]
    fn deref(&self) -> &T {
        &self.value
    }
}

impl<T> DerefMut for Counted<T> {
    #[inline]
    fn deref_mut(&mut self) -> &mut T {
        self.accesses = self.accesses.wrapping_add(1);
        &mut self.value
    }
}
