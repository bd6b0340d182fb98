//! `actuator scan`: who is on the bus.

use clap::Args;
use serde_json::json;

use super::{OnBus, dronecan, print_json, servo};
use crate::error::Error;
use crate::output::print_table;
use host_sim::can::scan;
use host_sim::table::{Cell, Table};

/// Lists the CANopen devices, DroneCAN nodes or servos of a bus
#[derive(Debug, Args)]
pub struct Scan {
    /// Gives node-IDs to DroneCAN nodes that ask for one, on a bus without an allocator
    #[arg(long)]
    allocate: bool,
    #[command(flatten)]
    bus: OnBus,
}

impl Scan {
    /// Requests the device type of all 127 node-IDs, and the identification of those that answer.
    ///
    /// # Errors
    /// Those of the bus.
    pub fn run(&self) -> Result<(), Error> {
        if let Some(mut servos) = self.bus.servos()? {
            return servo::scan(&mut servos, self.bus.json);
        }
        if let Some(mut client) = self.bus.dronecan()? {
            return dronecan::scan(&mut client, self.allocate, self.bus.json);
        }
        if self.allocate {
            let text = "--allocate concerns DroneCAN nodes: --bus dronecan:BUS";
            return Err(Error::Conflict(text.into()));
        }
        let mut client = self.bus.open(1)?;
        let nodes = scan::answering(&mut client)?;
        let devices: Vec<_> = nodes
            .into_iter()
            .map(|node| scan::identity(&mut client, node))
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
