//! Options about the same parameter that contradict each other.

use crate::model::ModelParameter;

/// An option and the parameters that it names, by name or symbol.
#[derive(Debug, Clone)]
pub struct ParameterOption<'a> {
    option: &'static str,
    parameters: Vec<&'a str>,
}

impl<'a> ParameterOption<'a> {
    /// The option of this name.
    pub fn new(option: &'static str, parameters: impl IntoIterator<Item = &'a String>) -> Self {
        Self {
            option,
            parameters: parameters.into_iter().map(String::as_str).collect(),
        }
    }

    /// Refuses a parameter of the table that both options name.
    ///
    /// # Errors
    /// A text with both options and the parameter.
    pub fn without(&self, other: &Self, table: &[ModelParameter]) -> Result<(), String> {
        let is_same = |a: &str, b: &str| is_same(table, a, b);
        let both = |name: &&&str| other.parameters.iter().any(|also| is_same(name, also));
        match self.parameters.iter().find(both) {
            None => Ok(()),
            Some(name) => Err(format!(
                "{} and {} both name {name}, expected one of them",
                self.option, other.option
            )),
        }
    }

    /// Refuses a parameter of the table that it names twice.
    ///
    /// # Errors
    /// A text with the option and the parameter.
    pub fn once(&self, table: &[ModelParameter]) -> Result<(), String> {
        for (index, name) in self.parameters.iter().enumerate() {
            let before = &self.parameters[..index];
            if before.iter().any(|also| is_same(table, name, also)) {
                let option = self.option;
                return Err(format!("{option} names {name} twice, expected it once"));
            }
        }
        Ok(())
    }
}

/// Whether two names denote the same parameter: one may be its symbol.
fn is_same(table: &[ModelParameter], a: &str, b: &str) -> bool {
    a == b || table.iter().any(|p| p.is_called(a) && p.is_called(b))
}
