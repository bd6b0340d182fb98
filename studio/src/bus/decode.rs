//! What a frame means: the service of CiA 301, the node, and the names of the objects in it.

use canopen::{CanFrame, cob_id};
use host_sim::can::fault_history::PastError;
use host_sim::can::names;
use host_sim::can::sdo::abort_text;

/// A decoded frame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Decoded {
    /// The service.
    pub service: &'static str,
    /// The node; 0 for all or none.
    pub node: u8,
    /// The content in words; empty where the service says all.
    pub content: String,
}

/// The name of an NMT state of a heartbeat.
pub fn nmt_state(state: u8) -> &'static str {
    match state {
        0 => "boot-up",
        4 => "stopped",
        5 => "operational",
        127 => "pre-operational",
        _ => "unknown",
    }
}

/// The name of an NMT command.
pub fn nmt_command(command: u8) -> &'static str {
    match command {
        1 => "start",
        2 => "stop",
        128 => "pre-operational",
        129 => "reset node",
        130 => "reset communication",
        _ => "unknown command",
    }
}

/// Decodes a frame by its identifier in the predefined connection set; `process_data` returns the
/// content of a PDO.
pub fn decode(frame: &CanFrame, process_data: impl Fn(&CanFrame) -> Option<String>) -> Decoded {
    let (id, is_extended) = frame.raw_id();
    let decoded = |service, node, content| Decoded {
        service,
        node,
        content,
    };
    if is_extended {
        return decoded("29-bit identifier", 0, String::new());
    }
    let ((function, node), data) = (cob_id::split(id), frame.bytes());
    match (function, node) {
        (cob_id::NMT, 0) => {
            let whom = match data[1] {
                0 => "all nodes".to_owned(),
                node => format!("node {node}"),
            };
            decoded("NMT", data[1], format!("{} {whom}", nmt_command(data[0])))
        }
        (cob_id::EMERGENCY, 0) => decoded("SYNC", 0, String::new()),
        (cob_id::EMERGENCY, _) => {
            let word = u32::from_le_bytes([data[0], data[1], data[3], data[4]]);
            let text = match u16::from_le_bytes([data[0], data[1]]) {
                0 => "error reset".to_owned(),
                code => format!("{code:04X}h {}", PastError::of_word(word).what()),
            };
            decoded("EMCY", node, text)
        }
        (cob_id::TIME, 0) => decoded("TIME", 0, String::new()),
        (cob_id::SDO_RESPONSE, 1..) => decoded("SDO response", node, sdo(data, true)),
        (cob_id::SDO_REQUEST, 1..) => decoded("SDO request", node, sdo(data, false)),
        (cob_id::HEARTBEAT, 1..) => {
            decoded("heartbeat", node, nmt_state(data[0] & 0x7F).to_owned())
        }
        _ if id == cob_id::LSS_RESPONSE => decoded("LSS response", 0, String::new()),
        _ if id == cob_id::LSS_REQUEST => decoded("LSS request", 0, String::new()),
        _ => match pdo(function) {
            Some(service) => decoded(service, node, process_data(frame).unwrap_or_default()),
            None => decoded("unknown", 0, String::new()),
        },
    }
}

/// The name of a PDO.
fn pdo(function: u32) -> Option<&'static str> {
    const NAMES: [[&str; 2]; 4] = [
        ["TPDO 1", "RPDO 1"],
        ["TPDO 2", "RPDO 2"],
        ["TPDO 3", "RPDO 3"],
        ["TPDO 4", "RPDO 4"],
    ];
    NAMES
        .iter()
        .zip(1..)
        .find_map(|([transmitted, received], number)| match function {
            _ if function == cob_id::tpdo(number) => Some(*transmitted),
            _ if function == cob_id::rpdo(number) => Some(*received),
            _ => None,
        })
}

/// The content of an SDO frame that names an object.
fn sdo(data: [u8; 8], is_response: bool) -> String {
    let [command, low, high, sub, value @ ..] = data;
    let index = u16::from_le_bytes([low, high]);
    let object = || {
        let row = names::find(&format!("{index:04X}:{sub}")).ok();
        row.map_or_else(|| format!("{index:04X}h:{sub}"), names::name)
    };
    let expedited = || {
        let length = 4 - usize::from(command >> 2 & 3);
        let row = names::find(&format!("{index:04X}:{sub}")).ok();
        let value = row.and_then(|row| names::decode(row.kind, &value[..length]));
        value.map_or_else(|| "?".to_owned(), |value| value.to_string())
    };
    match (command >> 5, is_response) {
        (4, _) => format!("{}: {}", object(), abort_text(u32::from_le_bytes(value))),
        (2, false) => format!("read {}", object()),
        (1, false) if command & 2 != 0 => format!("write {} = {}", object(), expedited()),
        (1, false) => format!("write {}", object()),
        (2, true) if command & 2 != 0 => format!("{} = {}", object(), expedited()),
        (2, true) => object(),
        (3, true) => format!("{} written", object()),
        (5, false) if command & 3 == 0 => format!("read {} by blocks", object()),
        _ => "segment".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_can::{Frame as _, StandardId};

    fn text(id: u16, data: &[u8]) -> (&'static str, u8, String) {
        let frame = CanFrame::new(StandardId::new(id).unwrap(), data).unwrap();
        let decoded = decode(&frame, |_| Some("angle 1".into()));
        (decoded.service, decoded.node, decoded.content)
    }

    #[test]
    fn frames_are_decoded_with_the_names_of_their_objects() {
        type Case = (u16, &'static [u8], (&'static str, u8, &'static str));
        let cases: [Case; 9] = [
            (0, &[1, 3], ("NMT", 3, "start node 3")),
            (0x80, &[], ("SYNC", 0, "")),
            (0x702, &[127], ("heartbeat", 2, "pre-operational")),
            (0x181, &[0; 8], ("TPDO 1", 1, "angle 1")),
            (
                0x601,
                &[0x40, 0x41, 0x60, 0, 0, 0, 0, 0],
                ("SDO request", 1, "read statusword"),
            ),
            (
                0x581,
                &[0x4B, 0x41, 0x60, 0, 0x37, 6, 0, 0],
                ("SDO response", 1, "statusword = 1591"),
            ),
            (
                0x601,
                &[0x23, 0x7A, 0x60, 0, 0x18, 0xFC, 0xFF, 0xFF],
                ("SDO request", 1, "write target-position = -1000"),
            ),
            (
                0x581,
                &[0x80, 0x41, 0x60, 0, 2, 0, 1, 6],
                (
                    "SDO response",
                    1,
                    "statusword: the object is read only (abort code 06010002h)",
                ),
            ),
            (
                0x81,
                &[0x21, 0x71, 0x21, 0x89, 0, 0, 0, 0],
                ("EMCY", 1, "7121h stall"),
            ),
        ];
        for (id, data, (service, node, content)) in cases {
            assert_eq!(
                text(id, data),
                (service, node, content.to_owned()),
                "{id:03X}"
            );
        }
    }
}
