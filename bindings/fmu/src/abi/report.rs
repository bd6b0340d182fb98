//! Messages to the host.

use std::ffi::{CStr, CString, c_void};

use super::types::{CallbackFunctions, Logger, Status};
use crate::description::ERROR_CATEGORY;

/// Access to the host's logger.
#[derive(Debug, Clone)]
pub struct Reporter {
    logger: Option<Logger>,
    environment: *mut c_void,
    name: CString,
}

impl Reporter {
    /// The reporter of an instance; without a logger it is silent.
    pub fn new(callbacks: &CallbackFunctions, name: &CStr) -> Self {
        Self {
            logger: callbacks.logger,
            environment: callbacks.component_environment,
            name: name.to_owned(),
        }
    }

    /// Reports the reason of a failed call to the host.
    pub fn report(&self, status: Status, message: &str) {
        let Some(logger) = self.logger else { return };
        let (category, message) = (without_nul(ERROR_CATEGORY), without_nul(&format(message)));
        // SAFETY: the host's logger takes a printf format and its arguments, here none. The strings
        // are null-terminated and valid until it returns. No part of the instance is borrowed, so
        // the logger may call back.
        unsafe {
            logger(
                self.environment,
                self.name.as_ptr(),
                status,
                category.as_ptr(),
                message.as_ptr(),
            );
        }
    }
}

/// The text as a printf format that prints exactly this text.
fn format(text: &str) -> String {
    text.replace('%', "%%")
}

fn without_nul(text: &str) -> CString {
    // Cannot fail without nul bytes; an empty message is better than none.
    CString::new(text.replace('\0', " ")).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_is_a_format_without_conversions_and_without_nul() {
        assert_eq!(format("100 %s %n"), "100 %%s %%n");
        assert_eq!(without_nul("a\0b").as_bytes(), b"a b");
    }
}
