//! The parameters of several structs as one list.

use model_core::parameter::{Group, Parameter, ParameterError, Value};

use crate::error::Error;
use host_sim::error::Error as SimulatorError;

/// Every parameter with its present value, in the order of the tables.
pub fn values<'a>(groups: &'a [&'a mut dyn Group]) -> impl Iterator<Item = Value> + 'a {
    let groups = groups.iter();
    groups.flat_map(|group| (0..).map_while(|index| group.value(index)))
}

/// Sets a parameter by name or by symbol.
///
/// # Errors
/// For an unknown name, with the command of `actuator` that lists the parameters, and for a value
/// out of range.
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
    Err(unknown(
        groups.iter().flat_map(|group| group.table()),
        name,
        command,
    ))
}

/// The error for a name that none of these parameters has; `command` lists them.
fn unknown(known: impl Iterator<Item = &'static Parameter>, name: &str, command: &str) -> Error {
    let known = known.flat_map(|parameter| [parameter.name, parameter.symbol]);
    let expected = format!("one that `actuator {command} --list-parameters` prints");
    SimulatorError::unknown("parameter", name, known, expected).into()
}
