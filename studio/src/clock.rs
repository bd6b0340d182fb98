//! The thread that keeps time: samples to the pages, supervision of motions, states and statistics.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::{Duration, Instant};

use serde_json::json;

use crate::attach;
use crate::core::{Core, State};
use crate::motion::Supervisor;
use crate::quantity;
use crate::record::Row;

/// Period of this thread.
const PERIOD: Duration = Duration::from_millis(10);

/// Period of the messages with samples: a little shorter than a frame of the screen.
const SAMPLES: Duration = Duration::from_millis(15);

/// Period of the request that a page must answer.
const TICK: Duration = Duration::from_millis(100);

/// Period in which the faults of actuators that have some are read again.
const FAULTS: Duration = Duration::from_secs(1);

/// Period of the display of the bus.
const BUS: Duration = Duration::from_millis(500);

/// The longest time until a change of a node is displayed.
const NODES: Duration = Duration::from_millis(50);

/// Runs until `stop` is set.
pub fn run(core: &Arc<Core>, stop: &AtomicBool) {
    let start = Instant::now();
    let mut supervisor = Supervisor::new(start);
    let [mut samples, mut tick, mut bus, mut nodes, mut faults] = [start; 5];
    let mut traced = 0;
    let is_due = |last: &mut Instant, period, now| {
        let is_due = now - *last >= period;
        if is_due {
            *last = now;
        }
        is_due
    };
    while !stop.load(Relaxed) {
        std::thread::sleep(PERIOD);
        let now = Instant::now();
        supervisor.tick(core, now);
        if is_due(&mut samples, SAMPLES, now) {
            send_samples(core);
        }
        if is_due(&mut tick, TICK, now) {
            core.pages.tell_all(&json!({ "event": "tick" }));
            check(core, now);
        }
        if is_due(&mut faults, FAULTS, now) {
            let faulty = core.with(|state| {
                let nodes = state.nodes.iter();
                let faulty = nodes.filter(|(_, node)| node.has_faults() && !node.is_lost);
                faulty.map(|(number, _)| *number).collect::<Vec<_>>()
            });
            faulty
                .into_iter()
                .for_each(|node| attach::refresh_faults(core, node));
        }
        if is_due(&mut nodes, NODES, now) {
            let changed =
                core.with(|state| std::mem::take(&mut state.has_changed).then(|| devices(state)));
            if let Some(changed) = changed {
                core.pages.tell_all(&changed);
            }
        }
        let elapsed = now - bus;
        if is_due(&mut bus, BUS, now) {
            let bit_rate = f64::from(core.kbit_s) * 1e3;
            let snapshot = core.with(|state| {
                state.statistics.update(elapsed.as_secs_f64(), bit_rate);
                let snapshot = state.statistics.snapshot(traced, core.now_s());
                traced = state.statistics.traced();
                snapshot
            });
            core.pages.tell_all(&snapshot);
        }
    }
}

/// The nodes, for the pages.
pub fn devices(state: &State) -> serde_json::Value {
    let nodes = state.nodes.iter();
    let nodes: Vec<_> = nodes.map(|(number, node)| node.snapshot(*number)).collect();
    json!({ "event": "devices", "nodes": nodes, "bus_problem": state.bus_problem })
}

/// Lost heartbeats, and a control that changes hands.
fn check(core: &Arc<Core>, now: Instant) {
    let (lost, control) = core.with(|state| {
        let nodes = state.nodes.iter_mut();
        let lost: Vec<_> = nodes
            .filter_map(|(number, node)| node.check_heartbeat(now).then_some(*number))
            .collect();
        state.has_changed |= !lost.is_empty();
        let control = state.control.expire(now).then(|| state.control.event());
        (lost, control)
    });
    for node in lost {
        core.log("fault", Some(node), "its heartbeat is lost");
    }
    if let Some(event) = control {
        core.pages.tell_all(&event);
    }
}

/// Appends the samples of a node to a message: the node-ID (u8), zero (u8), the number of rows
/// (u16) and of samples lost on the bus so far (u32), then the rows, the time as f64 and the
/// quantities as f32; little-endian.
fn put(
    bytes: &mut Vec<u8>,
    (node, lost): (u8, u64),
    quantities: usize,
    rows: impl ExactSizeIterator<Item = Row>,
) {
    let count = rows.len();
    bytes.reserve(8 + count * (8 + 4 * quantities));
    bytes.extend([node, 0]);
    bytes.extend((count as u16).to_le_bytes());
    bytes.extend((lost as u32).to_le_bytes());
    for row in rows {
        bytes.extend(row.time_s.to_le_bytes());
        for value in row.values.iter().take(quantities) {
            bytes.extend(value.to_le_bytes());
        }
    }
}

/// Sends the pages the samples that they lack.
fn send_samples(core: &Core) {
    let quantities = quantity::of(core).len();
    let (number, bytes, dropped) = core.with(|state| {
        let (mut number, mut bytes, mut dropped) = (0, Vec::new(), 0);
        for (node, entry) in &mut state.nodes {
            let record = &mut entry.record;
            dropped += std::mem::take(&mut record.dropped);
            if !record.pending.is_empty() {
                number += record.pending.len() as u64;
                let from = (*node, record.lost);
                put(&mut bytes, from, quantities, record.pending.drain(..));
            }
        }
        (number, bytes, dropped)
    });
    if dropped > 0 {
        core.pages
            .tell_all(&json!({ "event": "dropped", "samples": dropped }));
    }
    if number > 0 {
        core.pages.samples(number, bytes);
    }
}

/// Time of the recording that a new page gets, s.
const PAST_S: f64 = 10.0;

/// The samples of the last seconds.
pub fn past(state: &State, quantities: usize, now_s: f64) -> Vec<u8> {
    let mut bytes = Vec::new();
    for (node, entry) in &state.nodes {
        let ring = &entry.record.ring;
        let from = ring.partition_point(|row| row.time_s < now_s - PAST_S);
        // Rows that are still pending come with the next message.
        let to = ring
            .len()
            .saturating_sub(entry.record.pending.len())
            .max(from);
        let rows = ring.range(from..to).copied();
        put(&mut bytes, (*node, entry.record.lost), quantities, rows);
    }
    bytes
}
