//! Messages to the host.

use std::ffi::{CStr, CString, c_void};

use super::types::{CallbackFunctions, Logger, MessageLogger, Status};
use crate::description::ERROR_CATEGORY;

/// The logger of a host.
#[derive(Debug, Clone, Copy)]
enum HostLogger {
    /// Of FMI 2.0: a format of printf with its arguments.
    Format(Logger),
    /// Of FMI 3.0: a message.
    Message(MessageLogger),
}

/// Access to the host's logger.
#[derive(Debug, Clone)]
pub struct Reporter {
    logger: Option<HostLogger>,
    environment: *mut c_void,
    name: CString,
}

impl Reporter {
    /// The reporter of an instance; without a logger it is silent.
    pub fn new(callbacks: &CallbackFunctions, name: &CStr) -> Self {
        Self {
            logger: callbacks.logger.map(HostLogger::Format),
            environment: callbacks.component_environment,
            name: name.to_owned(),
        }
    }

    /// The reporter of an instance of FMI 3.0.
    pub fn of_messages(logger: Option<MessageLogger>, environment: *mut c_void) -> Self {
        Self {
            logger: logger.map(HostLogger::Message),
            environment,
            name: CString::default(),
        }
    }

    /// Reports the reason of a failed call to the host.
    pub fn report(&self, status: Status, message: &str) {
        let Some(logger) = self.logger else { return };
        let category = without_nul(ERROR_CATEGORY);
        let logger = match logger {
            HostLogger::Format(logger) => logger,
            HostLogger::Message(logger) => {
                let message = without_nul(message);
                // SAFETY: as below, without a format.
                unsafe {
                    logger(
                        self.environment,
                        status,
                        category.as_ptr(),
                        message.as_ptr(),
                    );
                }
                return;
            }
        };
        let message = without_nul(&format(message));
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
