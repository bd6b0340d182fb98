//! Reads MCAP, as ROS 2 and Foxglove record it: messages in CDR with their definition, and in JSON.
//!
//! Each message is a row at its own time with missing numbers for all others, as in a log of
//! ArduPilot. Topics without any usual name are left out.

#[cfg(feature = "mcap")]
pub use self::reader::read;

use super::{ImportError, Table};

/// The error of a program without this format.
#[cfg(not(feature = "mcap"))]
pub fn read(_: Vec<u8>, table: Table) -> Result<Table, ImportError> {
    Err(table.problem(1, super::not_built("an MCAP file")))
}

#[cfg(feature = "mcap")]
mod reader {
    use std::collections::{BTreeMap, BTreeSet};

    use mcap::{Channel, MessageStream};
    use serde_json::{Map, Value};

    use super::{ImportError, Table};
    use crate::data::{cdr::Definition, json, names};

    /// Longest message that is read, bytes: longer ones are of cameras.
    const LONGEST: usize = 1 << 14;
    /// Difference, ns, within which the stamp of a message and the time of the log are of one
    /// clock.
    const SAME_CLOCK_NS: u64 = 1_000_000_000;

    struct Row {
        time_s: f64,
        message: u64,
        values: Vec<(String, f64)>,
    }

    /// Reads the file. What follows damage is left out.
    pub fn read(bytes: Vec<u8>, mut table: Table) -> Result<Table, ImportError> {
        let damaged = |error: mcap::McapError| format!("a damaged MCAP file: {error}");
        let stream = MessageStream::new(&bytes).map_err(|e| table.problem(1, damaged(e)))?;
        let mut rows: Vec<Row> = Vec::new();
        let mut definitions = BTreeMap::new();
        let mut unread = BTreeSet::new();
        let mut first_ns = None;
        for (number, message) in (1..).zip(stream) {
            let message = match message {
                Ok(message) => message,
                Err(error) => {
                    let text = format!("{}; what follows is left out", damaged(error));
                    table.notes.push((number, text));
                    break;
                }
            };
            let channel = &message.channel;
            if message.data.len() > LONGEST {
                continue;
            }
            let Some(members) = members(channel, &message.data, &mut definitions) else {
                unread.insert(format!("`{}` ({})", channel.topic, encoding(channel)));
                continue;
            };
            let time_ns = time_ns(&members, message.log_time);
            let since_ns = time_ns - *first_ns.get_or_insert(time_ns);
            rows.extend(row(&channel.topic, &members, since_ns, number));
        }
        if rows.is_empty() {
            let unread: Vec<String> = unread.into_iter().collect();
            let problem = format!(
                "no message with the name of a quantity, expected topics in CDR with a definition \
                 `ros2msg`, or in JSON; not read are {}",
                unread.join(", ")
            );
            return Err(table.problem(1, problem));
        }
        rows.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        // The first of several values with the same name applies.
        rows.dedup_by(|later, row| {
            let is_same = later.time_s == row.time_s;
            if is_same {
                later.values.append(&mut row.values);
                row.values = std::mem::take(&mut later.values);
            }
            is_same
        });
        for row in rows {
            let time = std::iter::once(("time_s".to_owned(), row.time_s));
            table.push(row.message, time.chain(row.values));
        }
        // As ROS defines the angles and rates of joints.
        table.radians = true;
        Ok(table)
    }

    /// The members of a message; `None` in another encoding, or damaged.
    fn members(
        channel: &Channel<'_>,
        data: &[u8],
        definitions: &mut BTreeMap<u16, Definition>,
    ) -> Option<Map<String, Value>> {
        if channel.message_encoding == "json" {
            return serde_json::from_slice(data).ok();
        }
        let schema = channel.schema.as_ref()?;
        if (&*channel.message_encoding, &*schema.encoding) != ("cdr", "ros2msg") {
            return None;
        }
        let definition = definitions.entry(schema.id).or_insert_with(|| {
            Definition::of(&schema.name, &String::from_utf8_lossy(&schema.data))
        });
        definition.decoded(data)
    }

    fn encoding(channel: &Channel<'_>) -> String {
        let schema = channel.schema.as_ref();
        let schema = schema.map_or("no schema", |schema| &schema.encoding);
        format!("{}, {schema}", channel.message_encoding)
    }

    /// The time of a message, ns: its own stamp if that is of the clock of the log.
    fn time_ns(members: &Map<String, Value>, logged_ns: u64) -> i64 {
        let logged_ns = logged_ns as i64;
        let stamp = members.get("header").and_then(|header| header.get("stamp"));
        let part = |name| stamp?.get(name)?.as_i64();
        let stamp_ns = part("sec").zip(part("nanosec").or_else(|| part("nsec")));
        let stamp_ns = stamp_ns.map(|(s, ns)| s.saturating_mul(1_000_000_000).saturating_add(ns));
        let is_same = |ns: &i64| ns.abs_diff(logged_ns) < SAME_CLOCK_NS;
        stamp_ns.filter(is_same).unwrap_or(logged_ns)
    }

    /// The numbers of a message, if one of them has the name of a quantity.
    fn row(topic: &str, members: &Map<String, Value>, since_ns: i64, message: u64) -> Option<Row> {
        let mut values = Vec::new();
        json::flatten(members, "", &mut values);
        // The layout of an array and the stamp are no signals.
        let is_signal = |name: &str| !name.starts_with("header.") && !name.starts_with("layout.");
        values.retain(|(name, value)| !value.is_infinite() && is_signal(name));
        for (name, _) in &mut values {
            *name = format!("{topic}.{name}");
        }
        let is_usual = values.iter().any(|(name, _)| names::is_usual(name));
        is_usual.then_some(Row {
            time_s: since_ns as f64 / 1e9,
            message,
            values,
        })
    }
}
