//! Errors as Python exceptions.

use host_sim::error::Error;
use pyo3::{
    PyErr,
    exceptions::{PyKeyError, PyValueError},
};

/// `KeyError` for a parameter that does not exist, `ValueError` for everything else; `place` is
/// the prefix of the message.
pub fn exception(error: &Error, place: &str) -> PyErr {
    match error {
        Error::UnknownName {
            kind: "parameter",
            name,
            closest,
            ..
        } => {
            let guess = closest.as_ref();
            let guess = guess.map_or(String::new(), |name| format!(", did you mean `{name}`?"));
            PyKeyError::new_err(format!(
                "{place}unknown parameter `{name}`{guess}; \
                 expected one that smart_actuator.parameters() lists"
            ))
        }
        Error::UnknownName {
            kind: "input parameter",
            ..
        } => PyKeyError::new_err(format!("{place}{error}")),
        _ => PyValueError::new_err(format!("{place}{error}")),
    }
}

/// The [`exception`] of a single run.
pub fn raised(error: Error) -> PyErr {
    exception(&error, "")
}
