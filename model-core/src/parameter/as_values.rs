//! Serialisation of a parameter set: its values in the order of its table.
//!
//! Used by `#[serde(with = "...")]`, so that types defined by [`parameters!`](crate::parameters) in
//! other crates need no serde.

use core::{fmt, marker::PhantomData};

use serde::de::{Deserializer, Error, SeqAccess, Visitor};
use serde::ser::{SerializeTuple, Serializer};

use super::Parameters;

pub fn serialize<P: Parameters, S: Serializer>(
    parameters: &P,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    let mut tuple = serializer.serialize_tuple(P::TABLE.len())?;
    for value in (0..).map_while(|index| parameters.get(index)) {
        tuple.serialize_element(&value)?;
    }
    tuple.end()
}

/// Values outside their ranges are an error.
pub fn deserialize<'de, P: Parameters, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<P, D::Error> {
    deserializer.deserialize_tuple(P::TABLE.len(), Values(PhantomData))
}

struct Values<P>(PhantomData<P>);

impl<'de, P: Parameters> Visitor<'de> for Values<P> {
    type Value = P;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} parameter values", P::TABLE.len())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut values: A) -> Result<P, A::Error> {
        let mut parameters = P::default();
        for (index, parameter) in P::TABLE.iter().enumerate() {
            let value = values.next_element()?;
            let value = value.ok_or_else(|| A::Error::invalid_length(index, &self))?;
            if let Some(place) = parameters.get_mut(index) {
                *place = parameter.check(value).map_err(A::Error::custom)?;
            }
        }
        Ok(parameters)
    }
}
