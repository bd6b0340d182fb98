//! Several parameter structs taken as one list.

use model_core::parameter::{Parameter, ParameterError, Parameters};

use crate::error::Error;

/// Parameters behind one interface, whatever their table.
pub trait Group {
    /// What is known of each of them.
    fn table(&self) -> &'static [Parameter];

    /// The value of row `index` of the table; NaN beyond its end.
    fn value(&self, index: usize) -> f64;

    /// Sets one by name or by symbol.
    ///
    /// # Errors
    /// Those of [`Parameters::set`].
    fn assign(&mut self, name: &str, value: f64) -> Result<(), ParameterError>;
}

impl<P: Parameters> Group for P {
    fn table(&self) -> &'static [Parameter] {
        P::TABLE
    }

    fn value(&self, index: usize) -> f64 {
        self.get(index).unwrap_or(f64::NAN)
    }

    fn assign(&mut self, name: &str, value: f64) -> Result<(), ParameterError> {
        self.set(name, value)
    }
}

/// One parameter with its present value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Value {
    /// Its row in the table.
    pub parameter: &'static Parameter,
    /// Its value.
    pub value: f64,
}

/// Every parameter with its present value, in the order of the tables.
pub fn values(groups: &[&mut dyn Group]) -> Vec<Value> {
    let rows = groups.iter().flat_map(|group| {
        let rows = group.table().iter().enumerate();
        rows.map(|(index, parameter)| Value {
            parameter,
            value: group.value(index),
        })
    });
    rows.collect()
}

/// Sets a parameter by name or by symbol.
///
/// # Errors
/// [`Error::UnknownName`] where none has this name, with the command of `actuator` that lists them,
/// and [`Error::Parameter`] where it cannot take the value.
pub fn set(
    groups: &mut [&mut dyn Group],
    name: &str,
    value: f64,
    command: &str,
) -> Result<(), Error> {
    for group in groups.iter_mut() {
        match group.assign(name, value) {
            Err(ParameterError::Unknown) => {}
            result => return Ok(result?),
        }
    }
    let known = groups.iter().flat_map(|group| group.table());
    let known = known.flat_map(|parameter| [parameter.name, parameter.symbol]);
    let expected = format!("one that `actuator {command} --list-parameters` prints");
    Err(Error::unknown("parameter", name, known, expected))
}
