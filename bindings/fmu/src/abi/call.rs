//! What every function has in common: component, pointers, panics, messages.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::slice;

use super::types::{Component, Status};
use crate::instance::{Instance, Refusal};

pub type Result<T> = std::result::Result<T, Refusal>;

/// Does a call on an instance and reports to the host if it is refused.
///
/// # Safety
/// The component is null, or valid and used by nobody else.
pub unsafe fn call(
    component: *mut Component,
    function: &str,
    body: impl FnOnce(&mut Instance) -> Result<()>,
) -> Status {
    // SAFETY: null or valid, as promised.
    let Some(component) = (unsafe { component.as_mut() }) else {
        return Status::Error;
    };
    // What a panic left behind is not looked at: only a reset or a kept state leads on.
    let result = catch_unwind(AssertUnwindSafe(|| body(&mut component.instance)));
    let refusal = match result {
        Ok(Ok(())) => return Status::Ok,
        Ok(Err(refusal)) => refusal,
        Err(_) => {
            component.instance.fail();
            "an internal error; expected a reset, or a state that was kept".into()
        }
    };
    let status = if refusal.is_discard {
        Status::Discard
    } else {
        Status::Error
    };
    // A copy: the logger may call back, and may even free the component.
    let reporter = component.reporter.clone();
    reporter.report(status, &format!("{function}: {refusal}"));
    status
}

/// The elements that a pointer leads to.
///
/// # Safety
/// The pointer is null, or leads to so many elements that nobody changes for `'a`.
pub unsafe fn elements<'a, T>(pointer: *const T, count: usize, what: &str) -> Result<&'a [T]> {
    if count == 0 {
        return Ok(&[]);
    }
    check(pointer, count, what)?;
    // SAFETY: neither null nor misaligned nor too long; the rest as promised.
    Ok(unsafe { slice::from_raw_parts(pointer, count) })
}

/// As [`elements`], to be written.
///
/// # Safety
/// The pointer is null, or leads to so many elements that nobody else uses for `'a`.
pub unsafe fn elements_mut<'a, T>(
    pointer: *mut T,
    count: usize,
    what: &str,
) -> Result<&'a mut [T]> {
    if count == 0 {
        return Ok(&mut []);
    }
    check(pointer, count, what)?;
    // SAFETY: neither null nor misaligned nor too long; the rest as promised.
    Ok(unsafe { slice::from_raw_parts_mut(pointer, count) })
}

/// The place that a pointer leads to.
///
/// # Safety
/// The pointer is null, or leads to a place that nobody else uses for `'a`.
pub unsafe fn place<'a, T>(pointer: *mut T, what: &str) -> Result<&'a mut T> {
    check(pointer, 1, what)?;
    // SAFETY: neither null nor misaligned; the rest as promised.
    Ok(unsafe { &mut *pointer })
}

fn check<T>(pointer: *const T, count: usize, what: &str) -> Result<()> {
    if pointer.is_null() {
        return Err(format!("{what} is null").into());
    }
    let bytes = count.checked_mul(size_of::<T>());
    let is_possible = bytes.is_some_and(|bytes| isize::try_from(bytes).is_ok());
    if !(pointer.is_aligned() && is_possible) {
        return Err(format!("{what} is no place for {count} values").into());
    }
    Ok(())
}
