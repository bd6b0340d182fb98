//! Decodes messages of ROS 2: CDR in little-endian order, after the definition `ros2msg` that a
//! file of MCAP has of each type.

use std::collections::BTreeMap;

use serde_json::{Map, Value};

/// Most items of a list that are read: an image or a cloud of points is no list of joints.
const MOST_ITEMS: usize = 256;
/// Deepest message in messages.
const DEEPEST: usize = 16;
/// Bytes before the content, which name the encoding, and those of little-endian CDR.
const HEAD: usize = 4;
const LITTLE_ENDIAN: [u8; 2] = [0, 1];

/// The definition of a type, with those of the types in it.
pub struct Definition {
    root: String,
    messages: BTreeMap<String, Vec<Field>>,
}

struct Field {
    name: String,
    kind: String,
    count: Count,
}

#[derive(Clone, Copy)]
enum Count {
    One,
    Fixed(usize),
    Any,
}

impl Definition {
    /// Reads the definition of a type.
    pub fn of(name: &str, text: &str) -> Self {
        let root = plain(name);
        let mut messages: BTreeMap<String, Vec<Field>> = BTreeMap::new();
        let mut current = root.clone();
        for line in text.lines() {
            let line = line.split('#').next().unwrap_or_default().trim();
            if let Some(name) = line.strip_prefix("MSG:") {
                current = plain(name.trim());
            } else if let Some(field) = field(line, &current) {
                messages.entry(current.clone()).or_default().push(field);
            }
        }
        Self { root, messages }
    }

    /// The members of a message; `None` of one that is damaged or has another encoding.
    pub fn decoded(&self, message: &[u8]) -> Option<Map<String, Value>> {
        let (head, content) = message.split_at_checked(HEAD)?;
        let mut reader = Reader { content, place: 0 };
        head.starts_with(&LITTLE_ENDIAN)
            .then(|| self.members(&self.root, &mut reader, 0))?
    }

    fn members(&self, name: &str, reader: &mut Reader, depth: usize) -> Option<Map<String, Value>> {
        let mut members = Map::new();
        for field in self.messages.get(name).filter(|_| depth < DEEPEST)? {
            let count = match field.count {
                Count::One => {
                    let value = self.value(&field.kind, reader, depth)?;
                    members.insert(field.name.clone(), value);
                    continue;
                }
                Count::Fixed(count) => count,
                Count::Any => u32::from_le_bytes(reader.number()?) as usize,
            };
            // Each item has a byte at least.
            if count > reader.content.len() - reader.place {
                return None;
            }
            let mut items = Vec::new();
            for _ in 0..count {
                items.push(self.value(&field.kind, reader, depth)?);
            }
            if count <= MOST_ITEMS {
                members.insert(field.name.clone(), items.into());
            }
        }
        Some(members)
    }

    fn value(&self, kind: &str, reader: &mut Reader, depth: usize) -> Option<Value> {
        Some(match kind {
            "bool" => (reader.number::<1>()? != [0]).into(),
            "byte" | "char" | "uint8" => u8::from_le_bytes(reader.number()?).into(),
            "int8" => i8::from_le_bytes(reader.number()?).into(),
            "int16" => i16::from_le_bytes(reader.number()?).into(),
            "uint16" => u16::from_le_bytes(reader.number()?).into(),
            "int32" => i32::from_le_bytes(reader.number()?).into(),
            "uint32" => u32::from_le_bytes(reader.number()?).into(),
            "int64" => i64::from_le_bytes(reader.number()?).into(),
            "uint64" => u64::from_le_bytes(reader.number()?).into(),
            "float32" => f32::from_le_bytes(reader.number()?).into(),
            "float64" => f64::from_le_bytes(reader.number()?).into(),
            "string" => {
                let length = u32::from_le_bytes(reader.number()?) as usize;
                let text = reader.take(length)?.strip_suffix(&[0]).unwrap_or_default();
                String::from_utf8_lossy(text).into()
            }
            message => Value::Object(self.members(message, reader, depth + 1)?),
        })
    }
}

/// The name of a type without the folder of messages.
fn plain(name: &str) -> String {
    name.replace("/msg/", "/")
}

/// The field in a line of the definition of `message`; `None` of a constant and of other lines.
fn field(line: &str, message: &str) -> Option<Field> {
    let mut words = line.split_whitespace();
    let (kind, name) = (words.next()?, words.next()?);
    if name.contains('=') || words.next().is_some_and(|word| word.starts_with('=')) {
        return None;
    }
    let (kind, count) = match kind.split_once('[') {
        None => (kind, Count::One),
        Some((kind, count)) => match count.trim_end_matches(']').parse() {
            Ok(count) => (kind, Count::Fixed(count)),
            Err(_) => (kind, Count::Any),
        },
    };
    // A bounded string is encoded as any other.
    let kind = kind.split('<').next().unwrap_or(kind);
    let is_message = kind.starts_with(|c: char| c.is_ascii_uppercase());
    let package = message.split('/').next().unwrap_or_default();
    let kind = match kind {
        "Header" => "std_msgs/Header".into(),
        kind if is_message => format!("{package}/{kind}"),
        kind => plain(kind),
    };
    Some(Field {
        name: name.into(),
        kind,
        count,
    })
}

/// Reads a content in which each number is aligned to its size.
struct Reader<'a> {
    content: &'a [u8],
    place: usize,
}

impl<'a> Reader<'a> {
    fn number<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.place = self.place.next_multiple_of(N);
        self.take(N)?.try_into().ok()
    }

    fn take(&mut self, length: usize) -> Option<&'a [u8]> {
        let taken = self.content.get(self.place..)?.get(..length)?;
        self.place += length;
        Some(taken)
    }
}
