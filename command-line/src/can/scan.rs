//! `actuator scan`: who is on the bus.

use std::time::{Duration, Instant};

use canopen::CanFrame;
use clap::Args;
use embedded_can::{Frame, StandardId};
use serde_json::json;

use super::{OnBus, print_json};
use crate::error::Error;
use crate::output::print_table;
use host_sim::can::client::{Client, ClientError, state_name};
use host_sim::can::names::{self, Value};
use host_sim::table::{Cell, Table};

/// Lists the CANopen devices of a bus
#[derive(Debug, Args)]
pub struct Scan {
    #[command(flatten)]
    bus: OnBus,
}

/// The identification of a device; parts without a response are missing.
#[derive(Debug, serde::Serialize)]
struct Device {
    node: u8,
    name: Option<String>,
    software: Option<String>,
    product: Option<i64>,
    serial: Option<i64>,
    state: Option<&'static str>,
}

impl Scan {
    /// Requests the device type of all 127 node-IDs, and the identification of those that answer.
    ///
    /// # Errors
    /// Those of the bus.
    pub fn run(self) -> Result<(), Error> {
        self.scan()
    }

    fn scan(&self) -> Result<(), Error> {
        let mut client = self.bus.open(1)?;
        let nodes = answering(&mut client)?;
        let devices: Vec<_> = nodes
            .into_iter()
            .map(|node| look(&mut client, node))
            .collect();
        if self.bus.json {
            return print_json(&json!(devices));
        }
        let mut table = Table::new(
            "",
            &[
                ("node", ""),
                ("device", ""),
                ("software", ""),
                ("product", ""),
                ("serial", ""),
                ("state", ""),
            ],
        );
        for device in devices {
            let text = |text: Option<String>| text.map_or(Cell::None, Cell::Text);
            table.push([
                Cell::Number(device.node.into(), 0),
                text(device.name),
                text(device.software),
                text(device.product.map(|product| format!("{product:04X}h"))),
                text(device.serial.map(|serial| serial.to_string())),
                text(device.state.map(str::to_owned)),
            ]);
        }
        print_table(&table)
    }
}

/// The nodes that answer an upload request for object 1000h.
fn answering(client: &mut Client) -> Result<Vec<u8>, Error> {
    /// Sufficient unless a bus at 10 kbit/s is busy.
    const TIME: Duration = Duration::from_millis(500);
    let link = client.link();
    for node in 1..=127_u16 {
        let id = StandardId::new(0x600 + node).unwrap_or(StandardId::ZERO);
        if let Some(frame) = CanFrame::new(id, &[0x40, 0, 0x10, 0, 0, 0, 0, 0]) {
            link.send(&frame).map_err(ClientError::from)?;
        }
    }
    let (mut nodes, begun) = (Vec::new(), Instant::now());
    while let Some(left) = TIME.checked_sub(begun.elapsed()) {
        let frame = link.receive(left).map_err(ClientError::from)?;
        if let Some((id @ 0x581..=0x5FF, false)) = frame.map(|frame| frame.raw_id()) {
            nodes.push((id - 0x580) as u8);
        }
    }
    nodes.sort_unstable();
    nodes.dedup();
    Ok(nodes)
}

fn look(client: &mut Client, node: u8) -> Device {
    client.select_node(node);
    // Objects that a device of another vendor lacks are left out.
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
