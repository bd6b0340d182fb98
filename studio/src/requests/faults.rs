//! Faults, their history, and the counters of the board.

use std::sync::atomic::Ordering::Relaxed;

use canopen::cia402::statusword;
use canopen_generator::Row;
use host_sim::can::client::ClientError;
use host_sim::can::fault_history;
use host_sim::can::names;
use serde_json::json;

use super::Context;
use super::objects::address;
use crate::attach;

/// Index of the counters.
const DIAGNOSTICS: u16 = 0x2050;

fn counters() -> impl Iterator<Item = &'static Row> {
    let rows = names::rows().iter();
    rows.filter(|row| row.index == DIAGNOSTICS && (1..9).contains(&row.sub_index()))
}

pub fn read(context: Context, node: u8) {
    context.at_node(node, |core, client| {
        let history: Vec<_> = fault_history::history(client)?
            .into_iter()
            .map(|error| {
                let fault = error.fault().map(|row| row.fault.number());
                json!({ "code": error.code(), "what": error.what(), "fault": fault })
            })
            .collect();
        let mut values = serde_json::Map::new();
        for row in counters() {
            values.insert(address(row), (&client.get(row)?).into());
        }
        let (present, latched) = (client.integer("2050:9")?, client.integer("2050:10")?);
        core.with_node(client.node(), |node| {
            (node.present, node.latched) = (present, latched)
        });
        Ok::<_, ClientError>(json!({ "history": history, "counters": values }))
    });
}

pub fn reset(context: Context, node: u8) {
    context.at_node(node, |core, client| {
        if client.status()? & statusword::FAULT != 0 {
            client.reset_fault()?;
        }
        attach::refresh_faults(core, client.node());
        if client.status()? & statusword::FAULT != 0 {
            return client
                .fail_in_state("its cause is still there: see what to do beside each fault");
        }
        Ok::<_, ClientError>(json!(null))
    });
}

pub fn clear(context: Context, node: u8) {
    context.at_node(node, |_, client| {
        client.write("1003:0", "0")?;
        Ok::<_, ClientError>(json!(null))
    });
}

/// Breaks the encoder of a simulated actuator, or mends it.
pub fn break_encoder(context: &Context, node: u8, is_broken: bool) {
    let index = usize::from(node).checked_sub(1);
    let switches = &context.core.encoder_switches;
    let switch = index.and_then(|index| switches.get(index));
    let result = switch.ok_or_else(|| format!("actuator {node} is not simulated by this program"));
    context.reply.result(result.map(|switch| {
        switch.store(is_broken, Relaxed);
        json!(null)
    }));
}
