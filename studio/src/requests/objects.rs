//! Objects: read, written, saved and restored.

use canopen_generator::{Access, DataType, Row};
use host_sim::can::client::{Client, ClientError};
use host_sim::can::names;
use serde::Deserialize;
use serde_json::{Value, json};

use super::Context;
use crate::attach;

/// Groups of parameters that are saved.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Group {
    /// All.
    All,
    /// Those of the application: not what this program has changed in the telemetry.
    Application,
}

/// The address of an entry on the page.
pub fn address(row: &Row) -> String {
    format!("{:04X}:{}", row.index, row.sub_index())
}

/// Whether an entry has a value that can be shown.
pub fn is_readable(row: &Row) -> bool {
    row.access != Access::Wo && row.kind != DataType::Domain
}

fn get(client: &mut Client, row: &Row) -> Result<Value, ClientError> {
    client.get(row).map(|value| (&value).into())
}

pub fn read(context: Context, node: u8, objects: Vec<String>) {
    context.at_node(node, move |_, client| {
        let mut values = serde_json::Map::new();
        for object in &objects {
            let row = names::find(object).map_err(ClientError::from)?;
            values.insert(address(row), get(client, row)?);
        }
        Ok::<_, ClientError>(Value::Object(values))
    });
}

pub fn read_all(context: Context, node: u8) {
    context.at_node(node, |_, client| read_everything(client).map(Value::Object));
}

/// The values of all readable entries by their addresses; without those that the node refuses, such
/// as an empty history.
pub fn read_everything(client: &mut Client) -> Result<serde_json::Map<String, Value>, ClientError> {
    let mut values = serde_json::Map::new();
    for row in names::rows().iter().filter(|row| is_readable(row)) {
        match get(client, row) {
            Ok(value) => {
                values.insert(address(row), value);
            }
            Err(error) if error.is_refusal() => {}
            Err(error) => return Err(error),
        }
    }
    Ok(values)
}

pub fn write(context: Context, node: u8, object: String, value: String) {
    context.at_node(node, move |core, client| {
        let row = names::find(&object).map_err(ClientError::from)?;
        client.write(&object, &value)?;
        core.with_node(node, |node| node.unsaved.insert(address(row)));
        // What the node has made of it.
        Ok::<_, ClientError>(json!({ address(row): get(client, row)? }))
    });
}

pub fn save(context: Context, node: u8, group: Group) {
    let object = match group {
        Group::All => "1010:1",
        Group::Application => "1010:3",
    };
    sign(context, node, object, b"save");
}

pub fn restore(context: Context, node: u8) {
    let core = context.core.clone();
    context.at_node(node, move |_, client| {
        client.set(names::find("1011:1").map_err(ClientError::from)?, b"load")?;
        // The defaults are valid after a restart.
        client.manage(0x81)?;
        core.with_node(client.node(), |node| {
            node.original.clear();
            node.unsaved.clear();
        });
        Ok::<_, ClientError>(json!(null))
    });
}

fn sign(context: Context, node: u8, object: &'static str, signature: &'static [u8]) {
    context.at_node(node, move |core, client| {
        let row = names::find(object).map_err(ClientError::from)?;
        client.set(row, signature)?;
        core.with_node(client.node(), |node| node.unsaved.clear());
        attach::refresh_faults(core, client.node());
        Ok::<_, ClientError>(json!(null))
    });
}
