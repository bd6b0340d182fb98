//! `scan`, `get`, `set`, `monitor`, `move` and `stop` of DroneCAN nodes.

use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use ::dronecan::Target;
use host_sim::can::client::ClientError;
use host_sim::dronecan_client::{Client, NodeError, Parameter};
use host_sim::table::{Cell, Table};
use serde_json::json;

use super::objects::pair;
use super::print_json;
use crate::error::Error;
use crate::interrupt;
use crate::output::{print, print_table};

/// Deviation from a target that is reached, deg.
const REACHED_DEG: f64 = 1.0;

/// Time between two lines of telemetry.
const LINE: Duration = Duration::from_millis(100);

/// A node on the bus.
pub struct Node {
    client: Client,
    node: u8,
}

/// Lists the nodes of a bus.
pub fn scan(client: &mut Client, allocates: bool, json: bool) -> Result<(), Error> {
    let nodes = client.scan(allocates)?;
    if json {
        return print_json(&json!(nodes));
    }
    let names = ["node", "name", "software", "health", "uptime", "unique ID"];
    let mut table = Table::new("", &names.map(|name| (name, "")));
    for node in nodes {
        let uptime = format!("{} s", node.uptime_s);
        table.push([
            Cell::Number(node.node.into(), 0),
            Cell::Text(node.name),
            Cell::Text(node.software),
            Cell::Text(node.health.to_owned()),
            Cell::Text(uptime),
            Cell::Text(node.unique_id),
        ]);
    }
    print_table(&table)
}

impl Node {
    /// The node with this ID.
    pub fn new(client: Client, node: u8) -> Self {
        Self { client, node }
    }

    /// Prints parameters; without names all.
    ///
    /// # Errors
    /// For an unknown name; those of the bus.
    pub fn get(&mut self, names: &[String], json: bool) -> Result<(), Error> {
        let found: Vec<Parameter> = if names.is_empty() {
            self.client.parameters(self.node)?
        } else {
            let one = |name: &String| self.client.parameter(self.node, name);
            names.iter().map(one).collect::<Result<_, _>>()?
        };
        if json {
            let values = found.iter().map(|one| (one.name.clone(), json!(one.value)));
            return print_json(&serde_json::Value::Object(values.collect()));
        }
        if let [one] = &found[..] {
            return print(&format!("{}\n", one.value));
        }
        let names = ["parameter", "value", "default", "min", "max"];
        let mut table = Table::new("", &names.map(|name| (name, "")));
        for one in found {
            let contents = [one.value, one.default, one.min, one.max];
            let [value, default, min, max] = contents.map(|content| content.to_string());
            table.push([one.name, value, default, min, max].map(Cell::Text));
        }
        print_table(&table)
    }

    /// Writes parameters in order.
    ///
    /// # Errors
    /// For an unknown name or an invalid value; those of the bus and the node. Parameters before
    /// the failed one are written.
    pub fn set(&mut self, values: &[String], json: bool) -> Result<(), Error> {
        let pairs = values.iter().map(|text| pair(text));
        let pairs = pairs.collect::<Result<Vec<_>, _>>()?;
        for (name, value) in &pairs {
            self.client.set(self.node, name.trim(), value.trim())?;
        }
        if json {
            let written: Vec<_> = pairs.iter().map(|(name, _)| name.trim()).collect();
            print_json(&json!({ "written": written }))?;
        }
        Ok(())
    }

    /// Shows the status of the actuator.
    ///
    /// # Errors
    /// If it sends none; those of the bus.
    pub fn monitor(&mut self, is_over: impl Fn(Duration) -> bool, json: bool) -> Result<(), Error> {
        let (start, mut next) = (Instant::now(), Duration::ZERO);
        while !is_over(start.elapsed()) {
            let status = self.client.status(self.node)?;
            if start.elapsed() < next {
                continue;
            }
            next = start.elapsed() + LINE;
            if json {
                print_json(&json!(status))?;
            } else {
                print(&format!(
                    "angle {:.2} deg  rate {:.2} deg/s  torque {:.3} Nm\n",
                    status.angle_deg, status.rate_deg_s, status.torque_nm
                ))?;
            }
        }
        Ok(())
    }

    /// Commands an angle with each status until it is reached within this time, and returns the
    /// angle reached. Afterwards the actuator does what it does when commands stay away.
    ///
    /// # Errors
    /// If it is not reached; those of the bus.
    pub fn turn_to(&mut self, target_deg: f64, within: Duration) -> Result<f64, Error> {
        let actuator = self.client.status(self.node)?.actuator;
        let target = Target::Position(target_deg.to_radians() as f32);
        let (start, stop) = (Instant::now(), interrupt::stop()?);
        while !stop.load(Ordering::Relaxed) {
            self.client.command(actuator, target)?;
            let angle_deg = self.client.status(self.node)?.angle_deg;
            if (angle_deg - target_deg).abs() < REACHED_DEG {
                return Ok(angle_deg);
            }
            if start.elapsed() > within {
                let late = NodeError::NotReached {
                    node: self.node,
                    angle_deg,
                    target_deg,
                };
                return Err(late.into());
            }
        }
        Err(ClientError::Interrupted.into())
    }

    /// Releases the actuator, which stops first.
    ///
    /// # Errors
    /// Those of the bus.
    pub fn release(&mut self) -> Result<(), Error> {
        let actuator = self.client.status(self.node)?.actuator;
        Ok(self.client.command(actuator, Target::Position(f32::NAN))?)
    }
}
