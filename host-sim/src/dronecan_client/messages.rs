//! Payloads of requests, responses and messages.

use std::fmt;

use dronecan::{Payload, Reader, Target, float16};
use serde::Serialize;

/// The value of a parameter.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Content {
    /// None.
    Empty,
    /// An integer, or 0 and 1 of a Boolean.
    Integer(i64),
    /// A real number.
    Real(f32),
    /// A text.
    Text(String),
}

impl Content {
    /// A value of the same type.
    pub(super) fn parse(&self, value: &str) -> Option<Self> {
        match self {
            Self::Empty => None,
            Self::Integer(_) => value.parse().ok().map(Self::Integer),
            Self::Real(_) => value.parse().ok().map(Self::Real),
            Self::Text(_) => Some(Self::Text(value.to_owned())),
        }
    }

    /// A value with its type before it, as in `param.Value` and `param.NumericValue`.
    fn read(reader: &mut Reader<'_>) -> Self {
        match reader.unsigned(8) & 7 {
            1 => Self::Integer(reader.signed(64)),
            2 => Self::Real(reader.float32()),
            3 => Self::Integer((reader.unsigned(8) != 0).into()),
            4 => {
                let length = reader.unsigned(8) as usize;
                let bytes = reader.rest();
                reader.skip(length);
                Self::Text(text(bytes.get(..length).unwrap_or(bytes)))
            }
            _ => Self::Empty,
        }
    }
}

impl fmt::Display for Content {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => Ok(()),
            Self::Integer(value) => write!(f, "{value}"),
            Self::Real(value) => write!(f, "{value}"),
            Self::Text(value) => f.write_str(value),
        }
    }
}

/// A parameter of a node.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Parameter {
    /// Its name; empty for one that does not exist.
    pub name: String,
    /// Its value.
    pub value: Content,
    /// Its default.
    pub default: Content,
    /// Its least value.
    pub min: Content,
    /// Its greatest value.
    pub max: Content,
}

impl Parameter {
    pub(super) fn read(payload: &[u8]) -> Self {
        let mut reader = Reader::new(payload);
        let [value, default, max, min] = [(); 4].map(|()| Content::read(&mut reader));
        Self {
            name: text(reader.rest()),
            value,
            default,
            min,
            max,
        }
    }

    /// The values that it takes.
    pub(super) fn expected(&self) -> String {
        match (&self.value, &self.min, &self.max) {
            (Content::Text(_), ..) => "a text".to_owned(),
            (Content::Empty, ..) => "no value".to_owned(),
            (_, Content::Empty, Content::Empty) => "a number".to_owned(),
            (_, min, max) => format!("{min} to {max}"),
        }
    }
}

/// A request of a parameter by its place.
pub(super) fn get_by_index(index: u16) -> Payload {
    let mut payload = Payload::new();
    payload.unsigned(index.into(), 13).unsigned(0, 3);
    payload
}

/// A request of a parameter by its name, with a new value or none; `None` if it is too long.
pub(super) fn get_set(name: &str, value: &Content) -> Option<Payload> {
    let mut payload = Payload::new();
    payload.unsigned(0, 13);
    match value {
        Content::Empty => payload.unsigned(0, 3),
        Content::Integer(value) => payload.unsigned(1, 3).unsigned(*value as u64, 64),
        Content::Real(value) => payload.unsigned(2, 3).unsigned(value.to_bits().into(), 32),
        Content::Text(value) => {
            let length = u8::try_from(value.len()).ok()?;
            payload.unsigned(4, 3).put(&[length]).put(value.as_bytes())
        }
    };
    payload.put(name.as_bytes());
    payload.is_complete().then_some(payload)
}

/// A node, as it describes itself.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct NodeInfo {
    /// Its node-ID.
    pub node: u8,
    /// Its name.
    pub name: String,
    /// Version of its program.
    pub software: String,
    /// Its health: ok, warning, error or critical.
    pub health: &'static str,
    /// Seconds since its start.
    pub uptime_s: u64,
    /// Its unique identifier, hexadecimal.
    pub unique_id: String,
}

impl NodeInfo {
    pub(super) fn read(node: u8, payload: &[u8]) -> Self {
        let mut reader = Reader::new(payload);
        let uptime_s = reader.unsigned(32);
        let health = ["ok", "warning", "error", "critical"][reader.unsigned(2) as usize & 3];
        // Mode, code of the maker.
        reader.unsigned(6);
        reader.unsigned(16);
        let software = format!("{}.{}", reader.unsigned(8), reader.unsigned(8));
        // Flags, commit, CRC of the image, version of the hardware.
        reader.skip(1 + 4 + 8 + 2);
        let unique_id = (0..16)
            .map(|_| format!("{:02x}", reader.unsigned(8)))
            .collect();
        let certificate = reader.unsigned(8) as usize;
        reader.skip(certificate);
        Self {
            node,
            name: text(reader.rest()),
            software,
            health,
            uptime_s,
            unique_id,
        }
    }
}

/// The status of an actuator.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ActuatorStatus {
    /// Its actuator-ID.
    pub actuator: u8,
    /// Angle of the shaft, deg.
    pub angle_deg: f64,
    /// Torque, N m.
    pub torque_nm: f64,
    /// Rate, deg/s.
    pub rate_deg_s: f64,
}

impl ActuatorStatus {
    pub(super) fn read(payload: &[u8]) -> Self {
        let mut reader = Reader::new(payload);
        let actuator = reader.unsigned(8) as u8;
        let [angle, torque, rate] = [(); 3].map(|()| f64::from(reader.float16()));
        Self {
            actuator,
            angle_deg: angle.to_degrees(),
            torque_nm: torque,
            rate_deg_s: rate.to_degrees(),
        }
    }
}

/// A command of one actuator.
pub(super) fn command(actuator: u8, target: Target) -> Payload {
    let (kind, value) = match target {
        Target::Unitless(value) => (0, value),
        Target::Position(value) => (1, value),
        Target::Force(value) => (2, value),
        Target::Speed(value) => (3, value),
        Target::PulseWidth(value) => (4, value),
    };
    let mut payload = Payload::new();
    payload.put(&[actuator, kind]);
    payload.unsigned(float16::to_bits(value).into(), 16);
    payload
}

/// A text of a node, which need not be one.
fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}
