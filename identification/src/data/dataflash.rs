//! Reads the servo messages in the log of an ArduPilot autopilot: commanded pulses `RCOU`, pilot's
//! pulses `RCIN`, and the states that servos on CAN report, `CSRV`, by servo.
//!
//! After ArduPilot's "Logging: Binary format". Each message is a row at its own time with missing
//! numbers for all others: a command keeps its last value, an angle is not compared there.

use std::collections::BTreeMap;

use super::Table;

/// The two bytes before each message.
const HEAD: [u8; 2] = [0xa3, 0x95];
/// The type of the message that describes the others.
const FORMAT: u8 = 128;
/// The messages that are read.
const READ: [&str; 3] = ["CSRV", "RCOU", "RCIN"];

/// The layout of a message.
struct Layout {
    name: String,
    /// The type of each field by a letter.
    types: String,
    fields: Vec<String>,
    /// Its bytes, with the head.
    length: usize,
}

/// Reads the file. What is damaged is left out.
pub fn read(bytes: &[u8], mut table: Table) -> Table {
    let mut layouts: BTreeMap<u8, Layout> = BTreeMap::new();
    let mut rest = bytes;
    let mut place = 0;
    while let Some([a, b, kind]) = rest.first_chunk::<3>().copied() {
        let length = match layouts.get(&kind) {
            _ if [a, b] != HEAD => 1,
            _ if kind == FORMAT => {
                layouts.extend(rest.get(3..89).and_then(layout));
                89
            }
            Some(layout) => {
                let body = rest.get(3..layout.length).unwrap_or_default();
                if READ.contains(&&*layout.name) {
                    table.push(place, row(layout, body));
                }
                layout.length
            }
            None => 3,
        };
        place += length as u64;
        rest = rest.get(length..).unwrap_or_default();
    }
    for (index, name) in table.names.clone().iter().enumerate() {
        // As DroneCAN defines them.
        match name.rsplit('.').next() {
            Some("Pos") => table.set_unit(index, "rad"),
            Some("Speed") => table.set_unit(index, "rad/s"),
            _ => {}
        }
    }
    table
}

/// The layout in a message, with the type that it is for.
fn layout(body: &[u8]) -> Option<(u8, Layout)> {
    let text = |range: std::ops::Range<usize>| {
        let text = String::from_utf8_lossy(&body[range]);
        text.trim_end_matches('\0').to_owned()
    };
    let length = usize::from(body[1]);
    let layout = Layout {
        name: text(2..6),
        types: text(6..22),
        fields: text(22..86).split(',').map(String::from).collect(),
        length,
    };
    (length > 3).then_some((body[0], layout))
}

/// The numbers of a message by name; those of a servo have its number.
fn row(layout: &Layout, mut body: &[u8]) -> Vec<(String, f64)> {
    let mut values = Vec::new();
    for (field, kind) in layout.fields.iter().zip(layout.types.chars()) {
        let Some(value) = number(kind, &mut body) else {
            break;
        };
        values.push((field, value));
    }
    let servo = values.iter().find(|(field, _)| *field == "Id");
    let servo = servo.map_or(String::new(), |(_, id)| id.to_string());
    let named = values.into_iter().map(|(field, value)| match &**field {
        "TimeUS" => ("time_s".to_owned(), value * 1e-6),
        field => (format!("{}{servo}.{field}", layout.name), value),
    });
    named.collect()
}

/// The number of this type, which is removed. `None` for text, and after the end.
fn number(kind: char, body: &mut &[u8]) -> Option<f64> {
    fn take<const N: usize>(body: &mut &[u8]) -> Option<[u8; N]> {
        let (taken, rest) = body.split_first_chunk()?;
        *body = rest;
        Some(*taken)
    }
    Some(match kind {
        'b' => i8::from_le_bytes(take(body)?).into(),
        'B' | 'M' => u8::from_le_bytes(take(body)?).into(),
        'h' => i16::from_le_bytes(take(body)?).into(),
        'H' => u16::from_le_bytes(take(body)?).into(),
        'i' | 'L' => i32::from_le_bytes(take(body)?).into(),
        'I' => u32::from_le_bytes(take(body)?).into(),
        'f' => f32::from_le_bytes(take(body)?).into(),
        'd' => f64::from_le_bytes(take(body)?),
        'c' => f64::from(i16::from_le_bytes(take(body)?)) * 0.01,
        'C' => f64::from(u16::from_le_bytes(take(body)?)) * 0.01,
        'e' => f64::from(i32::from_le_bytes(take(body)?)) * 0.01,
        'E' => f64::from(u32::from_le_bytes(take(body)?)) * 0.01,
        'q' => i64::from_le_bytes(take(body)?) as f64,
        'Q' => u64::from_le_bytes(take(body)?) as f64,
        _ => return None,
    })
}
