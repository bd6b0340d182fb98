//! Values of the library in memory that the caller owns.
//!
//! The caller's structs are opaque words. The library stores a mark and a value there, so that it
//! detects memory that it has not filled.
#![allow(
    unsafe_code,
    reason = "the caller's memory is reached through raw pointers"
)]

use core::ffi::{CStr, c_char};
use core::fmt::Write;
use core::mem::MaybeUninit;

use crate::error::{ACTUATOR_WHY_SIZE, Code, Error, Why};
use crate::text::Text;

/// A struct of the caller that holds a value of the library.
///
/// The value has no destructor and points to nothing of its own (nothing in `model-core` does), so
/// a copy of its bytes is another value: C may copy and discard it.
pub trait Holds: Sized {
    /// The value.
    type Value;
    /// The mark of the type: eight characters, of which the last is the version of the layout.
    const MARK: u64;
    /// Fails to compile if the value does not fit or has a destructor.
    const FITS: () = {
        assert!(size_of::<Marked<Self::Value>>() <= size_of::<Self>());
        assert!(align_of::<Marked<Self::Value>>() <= align_of::<Self>());
        assert!(!core::mem::needs_drop::<Self::Value>());
    };
}

/// A value preceded by its type mark.
#[repr(C)]
pub struct Marked<T> {
    mark: u64,
    value: MaybeUninit<T>,
}

/// Checks the pointer of the caller.
pub fn check<T>(memory: *const T) -> Result<(), Code> {
    if memory.is_null() || !memory.is_aligned() {
        return Err(Code::Pointer);
    }
    Ok(())
}

/// The same, where a value of the library is.
fn place<H: Holds>(memory: *const H) -> Result<*const Marked<H::Value>, Code> {
    const { H::FITS };
    check(memory)?;
    Ok(memory.cast())
}

/// Fills the caller's memory with the value of `make`; on an error the memory holds no value
/// afterwards.
///
/// # Safety
/// `memory` is null, misaligned or the caller's own, `size` bytes of it.
pub unsafe fn fill<H: Holds, E: From<Code>>(
    memory: *mut H,
    size: usize,
    make: impl FnOnce() -> Result<H::Value, E>,
) -> Result<(), E> {
    if size != size_of::<H>() {
        return Err(place(memory).err().unwrap_or(Code::Size).into());
    }
    // SAFETY: the contract of this function.
    unsafe { fill_with_tail(memory, size, || Ok((make()?, 0))) }
}

/// As [`fill`], for a value that is followed by a number of doubles, which become zero; the memory
/// may be larger than both.
///
/// # Safety
/// As [`fill`].
pub unsafe fn fill_with_tail<H: Holds, E: From<Code>>(
    memory: *mut H,
    size: usize,
    make: impl FnOnce() -> Result<(H::Value, usize), E>,
) -> Result<(), E> {
    let place = place(memory)?.cast_mut();
    if size < size_with_tail::<H>(0) {
        return Err(Code::Size.into());
    }
    // Written part by part, since a whole would be on the stack first.
    // SAFETY: not null, aligned, and large enough, which is checked; the caller owns it.
    unsafe {
        (&raw mut (*place).mark).write(0);
        let (value, tail) = make()?;
        if size < size_with_tail::<H>(tail) {
            return Err(Code::Size.into());
        }
        (&raw mut (*place).value).write(MaybeUninit::new(value));
        place.add(1).cast::<f64>().write_bytes(0, tail);
        (&raw mut (*place).mark).write(H::MARK);
    }
    Ok(())
}

/// Bytes of a value that is followed by this number of doubles.
pub const fn size_with_tail<H: Holds>(tail: usize) -> usize {
    const { assert!(size_of::<Marked<H::Value>>().is_multiple_of(size_of::<f64>())) };
    size_of::<Marked<H::Value>>() + tail * size_of::<f64>()
}

/// The value in the caller's memory.
///
/// # Safety
/// `memory` is null, misaligned, or the caller's own: zeroed, or filled by [`fill`].
pub unsafe fn look<'a, H: Holds>(memory: *const H) -> Result<&'a H::Value, Code> {
    // SAFETY: not null, aligned, and large enough by `FITS`; it does not change during the call.
    let marked = unsafe { &*place(memory)? };
    if marked.mark != H::MARK {
        return Err(Code::NotReady);
    }
    // SAFETY: the mark is written by `fill` alone, together with the value.
    Ok(unsafe { marked.value.assume_init_ref() })
}

/// The value in the caller's memory and the doubles behind it.
///
/// # Safety
/// As [`look`]; `tail` returns the number of doubles that the memory was filled with.
pub unsafe fn look_with_tail<'a, H: Holds>(
    memory: *const H,
    tail: impl FnOnce(&H::Value) -> usize,
) -> Result<(&'a H::Value, &'a [f64]), Code> {
    // SAFETY: the contract of this function.
    let value = unsafe { look(memory)? };
    let count = tail(value);
    // SAFETY: behind the value, in the memory that was filled with both, and aligned as it is.
    let tail = unsafe {
        let first = memory.cast::<Marked<H::Value>>().add(1).cast::<f64>();
        core::slice::from_raw_parts(first, count)
    };
    Ok((value, tail))
}

/// The value in the caller's memory, to be changed.
///
/// # Safety
/// As [`look`], and no other thread uses it during the call.
pub unsafe fn change<'a, H: Holds>(memory: *mut H) -> Result<&'a mut H::Value, Code> {
    // SAFETY: not null, aligned, and large enough by `FITS`; this call has exclusive access.
    let marked = unsafe { &mut *place(memory)?.cast_mut() };
    if marked.mark != H::MARK {
        return Err(Code::NotReady);
    }
    // SAFETY: the mark is written by `fill` alone, together with the value.
    Ok(unsafe { marked.value.assume_init_mut() })
}

/// The value in the caller's memory and the doubles behind it, to be changed.
///
/// # Safety
/// As [`change`]; `tail` returns the number of doubles that was passed to [`fill_with_tail`].
pub unsafe fn change_with_tail<'a, H: Holds>(
    memory: *mut H,
    tail: impl FnOnce(&H::Value) -> usize,
) -> Result<(&'a mut H::Value, &'a mut [f64]), Code> {
    // SAFETY: the contract of this function.
    let value = unsafe { change(memory)? };
    let count = tail(value);
    // SAFETY: behind the value, in the memory that was filled with both, and aligned as it is.
    let tail = unsafe {
        let first = memory.cast::<Marked<H::Value>>().add(1).cast::<f64>();
        core::slice::from_raw_parts_mut(first, count)
    };
    Ok((value, tail))
}

/// Writes a result to the caller's memory.
///
/// # Safety
/// `out` is null, misaligned or the caller's own.
pub unsafe fn put<T>(out: *mut T, value: T) -> Result<(), Code> {
    check(out)?;
    // SAFETY: not null and aligned; the caller owns it.
    unsafe { out.write(value) };
    Ok(())
}

/// The code of a result, and its sentence unless `why` is null.
///
/// # Safety
/// `why` is null, misaligned or the caller's own.
pub unsafe fn explain(result: Result<(), Error<'_>>, why: *mut Why) -> Code {
    let mut text = Text::<ACTUATOR_WHY_SIZE>::default();
    let code = match &result {
        Ok(()) => Code::None,
        Err(error) => {
            // A text that is too long is truncated, which is not an error.
            let _ = write!(text, "{error}");
            error.code()
        }
    };
    // Null requests no sentence.
    // SAFETY: the contract of this function.
    let _ = unsafe { put(why, Why { text: text.0 }) };
    code
}

/// The caller's text; text that is not UTF-8 is not a known name.
///
/// # Safety
/// `text` is null or ends in a zero, and is not modified during the call.
pub unsafe fn text<'a>(text: *const c_char) -> Result<&'a str, Code> {
    if text.is_null() {
        return Err(Code::Pointer);
    }
    // SAFETY: not null; it ends in a zero by the contract.
    let text = unsafe { CStr::from_ptr(text) };
    text.to_str().map_err(|_| Code::Name)
}
