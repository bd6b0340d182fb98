//! Finds nodes, sets actuators up for this program, and leaves them as they were.

use std::sync::Arc;

use canopen::cob_id::SDO_RESPONSE;
use canopen_generator::Default as DefaultValue;
use host_sim::can::bus_load::{Traffic, share};
use host_sim::can::client::{Client, ClientError};
use host_sim::can::mapped::{Changes, mapping};
use host_sim::can::telemetry::Telemetry;
use host_sim::can::{names, scan as devices};
use model_core::time::CONTROL_RATE_HZ;

use crate::core::{Core, Task};
use crate::node::HEARTBEAT_MS;

/// Objects of the telemetry that the default PDOs lack: TPDO 4 with demand and supply voltage in
/// each control period, and the temperature behind the content of TPDO 3.
const DEMAND_AND_SUPPLY: [&str; 2] = ["6062", "6079"];
const TEMPERATURE: &str = "2006";

/// Load of the bus above which TPDO 4 is not added.
const MOST_LOAD: f64 = 0.8;

/// Identifies all nodes of the bus, and sets the actuators among them up.
pub fn scan(core: &Arc<Core>, task: &Task) {
    let mut client = Client::new(
        Box::new(core.hub.link(SDO_RESPONSE + 1..=SDO_RESPONSE + 127)),
        1,
    );
    let found = match devices::answering(&mut client) {
        Ok(found) => found,
        Err(error) => return core.log("fault", None, &error.to_string()),
    };
    drop(client);
    for (done, node) in found.iter().enumerate() {
        task.progress("nodes", done, found.len());
        if task.is_stopped() {
            return;
        }
        core.with(|state| {
            let entry = state.nodes.entry(*node).or_default();
            entry.device.node = *node;
            state.has_changed = true;
        });
        request(core, *node);
    }
    task.progress("nodes", found.len(), found.len());
}

/// Identifies a node and sets it up, after other work for it.
pub fn request(core: &Arc<Core>, node: u8) {
    let shared = Arc::clone(core);
    let requested = core.at_node(node, move |client| {
        let is_attached = shared.with_node(node, |node| node.is_attached);
        if is_attached == Some(true) {
            return;
        }
        let problem = attach(&shared, node, client).err();
        if let Some(problem) = &problem {
            shared.log(
                "warning",
                Some(node),
                &format!("cannot be set up: {problem}"),
            );
        }
        shared.with_node(node, |node| {
            node.problem = problem.map(|problem| problem.to_string())
        });
    });
    if requested.is_err() {
        core.log(
            "warning",
            Some(node),
            "has too much to do to be set up; scan again",
        );
    }
}

/// The product code of the actuator, as its dictionary says.
fn product() -> Option<i64> {
    match &names::find("1018:2").ok()?.default {
        DefaultValue::Integer(code, _) => i64::try_from(*code).ok(),
        _ => None,
    }
}

fn attach(core: &Arc<Core>, number: u8, client: &mut Client) -> Result<(), ClientError> {
    let device = devices::identity(client, number);
    let is_actuator = device.product.is_some() && device.product == product();
    core.with_node(number, |node| {
        (node.device, node.is_actuator) = (device.clone(), is_actuator);
    });
    if !is_actuator {
        return Ok(());
    }
    let mut changes = Changes::new(client);
    changes.write("1017", &HEARTBEAT_MS.to_string())?;
    let actuators = core.with(|state| state.nodes.values().filter(|n| n.is_actuator).count());
    if load(actuators, core.kbit_s) < MOST_LOAD {
        changes.map(4, 0, &DEMAND_AND_SUPPLY)?;
        let period_ms = (1000 / CONTROL_RATE_HZ).to_string();
        changes.write("1803:5", &period_ms)?;
    }
    let kept = changes.client.integer("1A02:0")? as u8;
    let last = changes.client.integer(&format!("1A02:{kept}"))? as u32;
    if last != mapping(TEMPERATURE)? {
        changes.map(3, kept, &[TEMPERATURE])?;
    }
    let original = changes.original;
    let telemetry = Telemetry::of(client)?;
    let status = client.status()?;
    let (present, latched) = (client.integer("2050:9")?, client.integer("2050:10")?);
    client.manage(1)?;
    let name = device.name.unwrap_or_default();
    core.with_node(number, |node| {
        // What an earlier set-up has kept is the original.
        if node.original.is_empty() {
            node.original = original;
        }
        node.telemetry = Some(telemetry);
        node.statusword = Some(status);
        (node.present, node.latched) = (present, latched);
        node.is_attached = true;
    });
    let serial = device.serial.unwrap_or_default();
    core.log(
        "info",
        Some(number),
        &format!("found: {name}, serial number {serial}"),
    );
    Ok(())
}

/// Load of the bus with the telemetry of this many actuators, as a share.
fn load(actuators: usize, kbit_s: u16) -> f64 {
    let rate_hz = f64::from(CONTROL_RATE_HZ);
    let tpdo = |bytes, rate_hz| Traffic {
        what: "",
        bytes,
        rate_hz,
    };
    let traffic = [
        tpdo(8, rate_hz),
        tpdo(8, rate_hz),
        tpdo(8, rate_hz),
        tpdo(7, 50.0),
    ];
    share(&traffic, f64::from(kbit_s) * 1e3).1 * actuators.max(1) as f64
}

/// Reads the faults of an actuator, after other work for it.
pub fn refresh_faults(core: &Arc<Core>, node: u8) {
    let shared = Arc::clone(core);
    // A later message repeats the request.
    let _ = core.at_node(node, move |client| {
        let bits = client
            .integer("2050:9")
            .and_then(|present| Ok((present, client.integer("2050:10")?, client.status()?)));
        if let Ok((present, latched, status)) = bits {
            let before = shared.with_node(node, |node| {
                let before = (node.present, node.latched);
                (node.present, node.latched) = (present, latched);
                // A node that is not operational sends none.
                if node.nmt != Some(5) {
                    node.statusword = Some(status);
                }
                before
            });
            if before != Some((present, latched)) {
                shared
                    .pages
                    .tell_all(&serde_json::json!({ "event": "faults", "node": node }));
            }
        }
    });
}

/// After a drive is off: it no longer watches the heartbeat of this program.
pub fn release(core: &Arc<Core>, node: u8) {
    let shared = Arc::clone(core);
    // It is written again with the next enabling.
    let _ = core.at_node(node, move |client| {
        let is_enabled = shared.with_node(node, |node| node.enabled_by.is_some());
        if is_enabled == Some(false) && client.write("1016:1", "0").is_ok() {
            shared.with_node(node, |node| node.is_watching = false);
        }
    });
}
