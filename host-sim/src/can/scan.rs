//! Who is on a bus: nodes that answer, and their identity.

use std::time::{Duration, Instant};

use canopen::{CanFrame, cob_id};
use embedded_can::Frame;

use super::client::{Client, ClientError, state_name};
use super::names::{self, Value};

/// The identity of a device; parts without a response are missing.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct Device {
    /// Its node-ID.
    pub node: u8,
    /// Manufacturer device name, 1008h.
    pub name: Option<String>,
    /// Manufacturer software version, 100Ah.
    pub software: Option<String>,
    /// Product code, 1018h:2.
    pub product: Option<i64>,
    /// Serial number, 1018h:4.
    pub serial: Option<i64>,
    /// State of the drive, from 6041h.
    pub state: Option<&'static str>,
}

/// Sufficient for all answers unless a bus at 10 kbit/s is busy.
const TIME: Duration = Duration::from_millis(500);

/// The nodes that answer an upload request for object 1000h.
///
/// # Errors
/// [`ClientError::Link`].
pub fn answering(client: &mut Client) -> Result<Vec<u8>, ClientError> {
    let link = client.link();
    for node in 1..=127 {
        let id = cob_id::of_node(cob_id::SDO_REQUEST, node);
        if let Some(frame) = CanFrame::new(id, &[0x40, 0, 0x10, 0, 0, 0, 0, 0]) {
            link.send(&frame)?;
        }
    }
    let (mut nodes, begun) = (Vec::new(), Instant::now());
    while let Some(left) = TIME.checked_sub(begun.elapsed()) {
        let frame = link.receive(left)?;
        let Some((id, false)) = frame.map(|frame| frame.raw_id()) else {
            continue;
        };
        if let (cob_id::SDO_RESPONSE, node @ 1..) = cob_id::split(id) {
            nodes.push(node);
        }
    }
    nodes.sort_unstable();
    nodes.dedup();
    Ok(nodes)
}

/// The identity of a node. Objects that a device of another vendor lacks are left out.
pub fn identity(client: &mut Client, node: u8) -> Device {
    client.select_node(node);
    let mut get = |object| {
        names::find(object)
            .ok()
            .and_then(|row| client.get(row).ok())
    };
    let text = |value| match value {
        Some(Value::Text(text)) => Some(text),
        _ => None,
    };
    let integer = |value| match value {
        Some(Value::Integer(value)) => Some(value),
        _ => None,
    };
    Device {
        node,
        name: text(get("1008")),
        software: text(get("100A")),
        product: integer(get("1018:2")),
        serial: integer(get("1018:4")),
        state: integer(get("6041")).map(|status| state_name(status as u16)),
    }
}
