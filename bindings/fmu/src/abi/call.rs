//! What every function has in common: component, pointers, panics, messages.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::slice;

use super::component::Component;
use super::types::Status;
use crate::instance::{Instance, Refusal};

pub type Result<T> = std::result::Result<T, Refusal>;

/// C functions that take a component and return a status: what each does, its name in each version
/// of the standard that has it with these arguments, the arguments, and the body.
macro_rules! interface {
    ($($about:literal [$($function:ident),+] $arguments:tt $body:expr;)+) => {$($(
        interface!(@ $about $function $arguments $body);
    )+)+};
    (@ $about:literal $function:ident ($($argument:ident: $type:ty),*) $body:expr) => {
        #[doc = $about]
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $function(
            component: *mut $crate::abi::Component,
            $($argument: $type),*
        ) -> $crate::abi::Status {
            // SAFETY: component and pointers are from the host.
            unsafe { $crate::abi::call::call(component, stringify!($function), $body) }
        }
    };
}

/// Executes a call on an instance, and reports a refusal to the host.
///
/// # Safety
/// The component is null, or valid and not used by another thread.
pub unsafe fn call(
    component: *mut Component,
    function: &str,
    body: impl FnOnce(&mut Instance) -> Result<()>,
) -> Status {
    // SAFETY: null or valid, by the contract.
    let Some(component) = (unsafe { component.as_mut() }) else {
        return Status::Error;
    };
    // The state after a panic is not used: only a reset or a saved state leads out.
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

/// The elements behind a pointer.
///
/// # Safety
/// The pointer is null, or points to `count` elements that do not change for `'a`.
pub unsafe fn elements<'a, T>(pointer: *const T, count: usize, what: &str) -> Result<&'a [T]> {
    if count == 0 {
        return Ok(&[]);
    }
    check(pointer, count, what)?;
    // SAFETY: neither null nor misaligned nor too long; the rest by the contract.
    Ok(unsafe { slice::from_raw_parts(pointer, count) })
}

/// As [`elements`], for writing.
///
/// # Safety
/// The pointer is null, or points to `count` elements with exclusive access for `'a`.
pub unsafe fn elements_mut<'a, T>(
    pointer: *mut T,
    count: usize,
    what: &str,
) -> Result<&'a mut [T]> {
    if count == 0 {
        return Ok(&mut []);
    }
    check(pointer, count, what)?;
    // SAFETY: neither null nor misaligned nor too long; the rest by the contract.
    Ok(unsafe { slice::from_raw_parts_mut(pointer, count) })
}

/// The value behind a pointer.
///
/// # Safety
/// The pointer is null, or points to a value with exclusive access for `'a`.
pub unsafe fn place<'a, T>(pointer: *mut T, what: &str) -> Result<&'a mut T> {
    check(pointer, 1, what)?;
    // SAFETY: neither null nor misaligned; the rest by the contract.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::abi::{CallbackFunctions, fmi2Reset, fmi2Terminate, report::Reporter};
    use model_core::scenario;

    #[test]
    fn a_panic_ends_at_the_boundary_and_a_reset_mends_it() {
        let callbacks = CallbackFunctions {
            logger: None,
            allocate_memory: None,
            free_memory: None,
            step_finished: None,
            component_environment: std::ptr::null_mut(),
        };
        let mut component = Component {
            instance: Instance::new(scenario::choices().next().unwrap()),
            reporter: Reporter::new(&callbacks, c"test"),
            updates: None,
        };
        let c = &raw mut component;
        // SAFETY: the component is valid, and the test uses it alone.
        unsafe {
            assert_eq!(call(c, "test", |_| panic!("on purpose")), Status::Error);
            let enter = call(c, "test", Instance::enter_initialization);
            assert_eq!(enter, Status::Error);
            assert_eq!(fmi2Reset(c), Status::Ok);
            assert_eq!(call(c, "test", Instance::enter_initialization), Status::Ok);
            assert_eq!(fmi2Terminate(c), Status::Error);
        }
    }

    #[test]
    fn null_and_crooked_pointers_and_impossible_counts_are_refused() {
        let numbers = [0_u64; 2];
        let crooked = numbers.as_ptr().wrapping_byte_add(1);
        assert!(check(std::ptr::null::<u64>(), 1, "it").is_err());
        assert!(check(crooked, 1, "it").is_err());
        assert!(check(numbers.as_ptr(), usize::MAX / 8, "it").is_err());
        assert!(check(numbers.as_ptr(), 2, "it").is_ok());
    }
}
