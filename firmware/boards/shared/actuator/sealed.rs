//! Memory that must not change between two uses.

use core::{mem::MaybeUninit, ptr};

use super::words::{checksum_at, checksum_of, copy};

/// A value that a checksum protects while it is not in use.
pub struct Sealed<T: 'static> {
    content: &'static mut T,
    /// The checksum since the end of the last use; none during a use.
    checksum: Option<u32>,
    /// The bytes of the value at the start of a use, and the checksum that it then had.
    copy: &'static mut MaybeUninit<T>,
    copied: Option<u32>,
}

/// Result of [`Sealed::restore`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Restored {
    /// The value is what it was.
    Intact,
    /// The value is not what it was, and must not be used.
    Corrupt,
    /// There is no copy: the value is as it is.
    Absent,
}

impl<T> Sealed<T> {
    /// A value in use, with memory for a copy.
    pub fn new(content: &'static mut T, copy: &'static mut MaybeUninit<T>) -> Self {
        const { assert!(!core::mem::needs_drop::<T>()) }
        Self {
            content,
            checksum: None,
            copy,
            copied: None,
        }
    }

    /// As [`Sealed::unseal`], with a copy of the value for [`Sealed::restore`].
    pub fn unseal_and_copy(&mut self) -> bool {
        self.copied = self.checksum;
        let from = ptr::from_ref(&*self.content);
        // SAFETY: both are valid for one `T` and do not overlap. The copy is never used as a value
        // of its own, only to overwrite the value of which it was made.
        unsafe { copy(from, self.copy.as_mut_ptr()) }
        self.unseal()
    }

    /// Discards the copy.
    pub fn discard_copy(&mut self) {
        self.copied = None;
    }

    /// Makes the value what it was when it was copied, once.
    pub fn restore(&mut self) -> Restored {
        let Some(copied) = self.copied.take() else {
            return Restored::Absent;
        };
        let to = ptr::from_mut(self.content);
        // SAFETY: as in `unseal_and_copy`; the value that is overwritten needs no drop.
        unsafe { copy(self.copy.as_ptr(), to) }
        // After the copying, which may itself have failed.
        if Self::checksum(self.content) == copied {
            Restored::Intact
        } else {
            Restored::Corrupt
        }
    }

    /// Whether a part of the value, which nothing was to change since, has the bytes that it had
    /// when the value was copied.
    pub fn is_as_copied<U>(&self, part: impl FnOnce(&T) -> &U) -> bool {
        let part = ptr::from_ref(part(self.content));
        let offset = part
            .addr()
            .wrapping_sub(ptr::from_ref(&*self.content).addr());
        if offset > const { size_of::<T>().saturating_sub(size_of::<U>()) } {
            return false;
        }
        let copied = self
            .copy
            .as_ptr()
            .cast::<u8>()
            .wrapping_add(offset)
            .cast::<U>();
        // SAFETY: the part is valid, and a copy of it is at the same offset in the memory of the
        // copy, which has the same alignment and was written with the first copy of the value.
        // Only its bytes are read.
        unsafe { Self::checksum_of_part(part) == Self::checksum_of_part(copied) }
    }

    /// Not inlined: the bounds of its loops are stated by its name, and rely on the size.
    ///
    /// # Safety
    /// As for [`checksum_at`].
    #[inline(never)]
    unsafe fn checksum_of_part<U>(part: *const U) -> u32 {
        const { assert!(size_of::<U>() <= 9 * 32) };
        // SAFETY: the caller's.
        unsafe { checksum_at(part) }
    }

    /// Not inlined: the campaign of bit flips recognises its passes.
    #[inline(never)]
    fn checksum(content: &T) -> u32 {
        checksum_of(content)
    }

    /// Starts a use; returns whether the value is as it was at the end of the last use. If it is
    /// not, it must not be used.
    pub fn unseal(&mut self) -> bool {
        let sealed = self.checksum.take();
        sealed.is_none_or(|checksum| checksum == Self::checksum(self.content))
    }

    /// The value, during a use.
    pub fn get(&mut self) -> &mut T {
        self.content
    }

    /// Ends a use.
    pub fn seal(&mut self) {
        self.checksum = Some(Self::checksum(self.content));
    }
}
