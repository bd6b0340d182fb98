//! An instance with the functions of its host.

use std::ffi::{CStr, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr::null_mut;

use super::report::Reporter;
use super::types::Status;
use super::updates::IntermediateUpdates;
use crate::identity;
use crate::instance::Instance;
use model_core::actuator::Settings;

/// The target of `fmi2Component` and `fmi3Instance`.
#[derive(Debug)]
pub struct Component {
    pub(super) instance: Instance,
    pub(super) reporter: Reporter,
    /// The intermediate updates of a host of FMI 3.0 that requests them.
    pub(super) updates: Option<IntermediateUpdates>,
}

/// The component of an instance; null with a message if there is none.
pub fn made(
    function: &str,
    reporter: Reporter,
    updates: Option<IntermediateUpdates>,
    make: impl FnOnce() -> Result<Instance, String>,
) -> *mut Component {
    let why = match catch_unwind(AssertUnwindSafe(make)) {
        Ok(Ok(instance)) => {
            return Box::into_raw(Box::new(Component {
                instance,
                reporter,
                updates,
            }));
        }
        Ok(Err(why)) => why,
        Err(_) => "an internal error".to_owned(),
    };
    reporter.report(Status::Error, &format!("{function}: {why}"));
    null_mut()
}

/// The settings of an identifier, which is the argument `argument` of an instantiation.
///
/// # Safety
/// The pointers are null or lead to strings.
pub unsafe fn found(
    name: *const c_char,
    (identifier, argument): (*const c_char, &str),
    resources: *const c_char,
) -> Result<Settings, String> {
    // SAFETY: by the contract.
    let (name, identifier, resources) = unsafe { (text(name), text(identifier), text(resources)) };
    if name.is_none_or(CStr::is_empty) {
        return Err("instanceName is missing or empty".to_owned());
    }
    let identifier = identifier.ok_or_else(|| format!("{argument} is null"))?;
    let resources = resources.map(CStr::to_string_lossy);
    identity::find(&identifier.to_string_lossy(), resources.as_deref())
}

/// The string that a pointer leads to; `None` for null.
///
/// # Safety
/// The pointer is null, or leads to a string that ends in a nul and lives for `'a`.
pub unsafe fn text<'a>(pointer: *const c_char) -> Option<&'a CStr> {
    // SAFETY: not null; the rest as promised.
    (!pointer.is_null()).then(|| unsafe { CStr::from_ptr(pointer) })
}

/// Frees a component; null is ignored.
///
/// # Safety
/// Null, or from [`made`] and not used again.
pub unsafe fn free(component: *mut Component) {
    if !component.is_null() {
        // SAFETY: it comes from `Box::into_raw`, and is not used again.
        drop(unsafe { Box::from_raw(component) });
    }
}
