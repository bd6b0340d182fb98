//! Serialisation of a delay line: only the values in transit.

use core::{fmt, marker::PhantomData};

use serde::de::{Deserializer, Error, SeqAccess, Visitor};
use serde::ser::{SerializeSeq, Serializer};
use serde::{Deserialize, Serialize};

use super::{DelayLine, Ring};

/// Sequence: delay in ticks, whether a value was received, index of the oldest value, the values.
impl<R: Ring> Serialize for DelayLine<R> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let in_transit = self.ring.as_ref().get(..self.cursor.delay_ticks);
        let in_transit = in_transit.filter(|_| self.cursor.started);
        let count = in_transit.map_or(0, <[f64]>::len);
        let mut seq = serializer.serialize_seq(Some(3 + count))?;
        seq.serialize_element(&(self.cursor.delay_ticks as u64))?;
        seq.serialize_element(&in_transit.is_some())?;
        seq.serialize_element(&(self.cursor.oldest as u64))?;
        for value in in_transit.into_iter().flatten() {
            seq.serialize_element(value)?;
        }
        seq.end()
    }
}

impl<'de, R: Ring> Deserialize<'de> for DelayLine<R> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(Line(PhantomData))
    }
}

struct Line<R>(PhantomData<R>);

impl<'de, R: Ring> Visitor<'de> for Line<R> {
    type Value = DelayLine<R>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a delay in ticks, and the values in transit")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
        let missing = |at| A::Error::invalid_length(at, &self);
        let delay_ticks = seq.next_element()?.ok_or_else(|| missing(0))?;
        let has_begun = seq.next_element()?.ok_or_else(|| missing(1))?;
        let oldest: u64 = seq.next_element()?.ok_or_else(|| missing(2))?;
        let line = DelayLine::<R>::try_new(delay_ticks);
        let mut line = line.ok_or_else(|| A::Error::custom("a delay longer than the line"))?;
        if oldest != 0 && oldest >= delay_ticks {
            return Err(A::Error::custom("an index beyond the delay"));
        }
        line.cursor.oldest = oldest as usize;
        line.cursor.started = has_begun;
        if has_begun {
            let ring = line.ring.as_mut().iter_mut().take(line.cursor.delay_ticks);
            for (i, place) in ring.enumerate() {
                *place = seq.next_element()?.ok_or_else(|| missing(3 + i))?;
            }
        }
        Ok(line)
    }
}
