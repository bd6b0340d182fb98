//! Wishes about a parameter that cannot both be had.

use model_core::parameter::Parameter;

use crate::request::RequestError;

/// What an option wants, and of which parameters, by name or symbol.
#[derive(Debug, Clone)]
pub struct Wish<'a> {
    option: &'static str,
    parameters: Vec<&'a str>,
}

impl<'a> Wish<'a> {
    /// What is wanted by the option of this name.
    pub fn new(option: &'static str, parameters: impl IntoIterator<Item = &'a String>) -> Self {
        Self {
            option,
            parameters: parameters.into_iter().map(String::as_str).collect(),
        }
    }

    /// Refuses that both name a parameter of the table.
    ///
    /// # Errors
    /// [`RequestError::Conflict`] with both options and the parameter.
    pub fn without(&self, other: &Self, table: &[Parameter]) -> Result<(), RequestError> {
        let is_same = |a: &str, b: &str| is_same(table, a, b);
        let both = |name: &&&str| other.parameters.iter().any(|also| is_same(name, also));
        match self.parameters.iter().find(both) {
            None => Ok(()),
            Some(name) => Err(RequestError::Conflict(format!(
                "{} and {} both name {name}, expected one of them",
                self.option, other.option
            ))),
        }
    }

    /// Refuses that it names a parameter of the table twice.
    ///
    /// # Errors
    /// [`RequestError::Conflict`] with the option and the parameter.
    pub fn once(&self, table: &[Parameter]) -> Result<(), RequestError> {
        for (index, name) in self.parameters.iter().enumerate() {
            let before = &self.parameters[..index];
            if before.iter().any(|also| is_same(table, name, also)) {
                let option = self.option;
                return Err(RequestError::Conflict(format!(
                    "{option} names {name} twice, expected it once"
                )));
            }
        }
        Ok(())
    }
}

/// Whether two words name one parameter: a symbol and a name may.
fn is_same(table: &[Parameter], a: &str, b: &str) -> bool {
    a == b || table.iter().any(|p| p.is_called(a) && p.is_called(b))
}
