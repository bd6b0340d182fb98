//! The parameters by name: what is stored of the application, in the order of the object
//! dictionary.

use ::dronecan::{Parameter, Value};
use canopen::dictionary::{Access, DataType, Entry};
use canopen::{Abort, Application};

use super::Drive;
use crate::{
    dictionary::{DICTIONARY, LOCATIONS, Location, location},
    parameters::{BoardParameters, ObjectValue, ObjectValues, Parameter as BoardParameter},
};
use model_core::control::parameters::ControlParameters;
use model_core::parameter::Parameters;

/// A parameter's name and the number of its entry in the dictionary.
#[derive(Clone, Copy)]
struct Named {
    name: &'static str,
    entry: u16,
}

/// The name of a stored value, and its number among all; `None` for what is not stored or computed.
const fn stored(location: Location) -> Option<(&'static str, usize)> {
    const BOARD: usize = ControlParameters::TABLE.len();
    const VALUES: usize = BOARD + BoardParameter::ALL.len();
    Some(match location {
        Location::Control(row) => (ControlParameters::TABLE[row].name, row),
        Location::Parameter(parameter) => {
            let at = parameter as usize;
            (BoardParameter::FIELDS[at].0, BOARD + at)
        }
        Location::Value(value) => {
            let at = value as usize;
            (ObjectValue::FIELDS[at].0, VALUES + at)
        }
        _ => return None,
    })
}

/// Whether an entry is the first one of a stored value that can be read and written.
const fn is_parameter(at: usize) -> bool {
    let entries = DICTIONARY.entries();
    let Some((_, number)) = stored(LOCATIONS[at]) else {
        return false;
    };
    if !matches!(entries[at].access(), Access::ReadWrite) {
        return false;
    }
    let mut before = 0;
    while before < at {
        if let Some((_, other)) = stored(LOCATIONS[before])
            && other == number
        {
            return false;
        }
        before += 1;
    }
    true
}

const COUNT: usize = {
    let (mut at, mut count) = (0, 0);
    while at < LOCATIONS.len() {
        count += is_parameter(at) as usize;
        at += 1;
    }
    count
};

static PARAMETERS: [Named; COUNT] = {
    let mut named = [Named { name: "", entry: 0 }; COUNT];
    let (mut at, mut count) = (0, 0);
    while at < LOCATIONS.len() {
        if let Some((name, _)) = stored(LOCATIONS[at])
            && is_parameter(at)
        {
            let entry = at as u16;
            named[count] = Named { name, entry };
            count += 1;
        }
        at += 1;
    }
    named
};

/// Index of the parameter of a name.
pub(super) fn find(name: &[u8]) -> Option<u16> {
    let at = (PARAMETERS.iter()).position(|parameter| parameter.name.as_bytes() == name)?;
    Some(at as u16)
}

/// Name and entry of the parameter of an index.
fn at(index: u16) -> Option<(&'static str, &'static Entry)> {
    let named = PARAMETERS.get(usize::from(index))?;
    let entry = DICTIONARY.entries().get(usize::from(named.entry))?;
    Some((named.name, entry))
}

/// The value of a word.
fn value(data_type: DataType, word: u32) -> Value {
    match data_type {
        DataType::F32 => Value::Real(f32::from_bits(word)),
        DataType::I8 | DataType::I16 | DataType::I32 => Value::Integer((word as i32).into()),
        _ => Value::Integer(word.into()),
    }
}

/// The word of a value, if the type has it.
fn word(data_type: DataType, value: Value) -> Option<u32> {
    Some(match (data_type, value) {
        (DataType::F32, Value::Real(real)) => real.to_bits(),
        (DataType::F32, Value::Integer(it)) => (i32::try_from(it).ok()? as f32).to_bits(),
        (_, Value::Real(_)) => return None,
        (DataType::I8, Value::Integer(it)) => i32::from(i8::try_from(it).ok()?) as u32,
        (DataType::I16, Value::Integer(it)) => i32::from(i16::try_from(it).ok()?) as u32,
        (DataType::I32, Value::Integer(it)) => i32::try_from(it).ok()? as u32,
        (DataType::U8, Value::Integer(it)) => u8::try_from(it).ok()?.into(),
        (DataType::U16, Value::Integer(it)) => u16::try_from(it).ok()?.into(),
        (_, Value::Integer(it)) => u32::try_from(it).ok()?,
    })
}

/// The word of a default.
fn default_word(entry: &Entry) -> u32 {
    match location(entry) {
        Location::Control(row) => {
            let default = BoardParameters::DEFAULT.control.get(row);
            default.unwrap_or(0.0).to_bits()
        }
        Location::Parameter(parameter) => BoardParameters::DEFAULT.word(parameter),
        Location::Value(value) => ObjectValues::DEFAULT.word(value),
        _ => 0,
    }
}

impl Drive<'_> {
    /// The parameter of an index.
    pub(super) fn described(&mut self, index: u16) -> Option<Parameter> {
        let (name, entry) = at(index)?;
        let of = |word| value(entry.data_type(), word);
        let range = entry.limit_words();
        Some(Parameter {
            value: of(self.read(entry).ok()? as u32),
            default: of(default_word(entry)),
            range: range.map(|(least, greatest)| (of(least), of(greatest))),
            name,
        })
    }

    /// Sets the parameter of an index.
    ///
    /// # Errors
    /// Those of a write of its object.
    pub(super) fn set_described(&mut self, index: u16, value: Value) -> Result<(), Abort> {
        let (_, entry) = at(index).ok_or(Abort::NoObject)?;
        if entry.is_guarded() && self.guarded() {
            return Err(Abort::DeviceState);
        }
        let word = word(entry.data_type(), value).ok_or(Abort::Value)?;
        if let Location::Value(value) = location(entry) {
            let mut values = self.values;
            values.set_word(value, word);
            values.check().map_err(|_| Abort::Value)?;
        }
        self.write(entry, word.into())
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use std::collections::HashSet;

    #[test]
    fn every_parameter_has_a_name_of_its_own_and_is_found_by_it() {
        let names: HashSet<_> = PARAMETERS.iter().map(|parameter| parameter.name).collect();
        assert_eq!(names.len(), COUNT);
        for (index, parameter) in (0..).zip(&PARAMETERS) {
            assert_eq!(find(parameter.name.as_bytes()), Some(index));
        }
        // All but the password, which cannot be read, the source of the commands, and the origin,
        // which homing sets.
        let stored = ControlParameters::TABLE.len() + BoardParameter::ALL.len();
        assert_eq!(COUNT, stored + ObjectValue::ALL.len() - 3);
        assert_eq!(find(b"password"), None);
    }
}
