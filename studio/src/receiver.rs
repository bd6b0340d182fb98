//! The thread that receives: opens the bus, again where it was lost, and passes every frame on.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::{Duration, Instant};

use canopen::{CanFrame, cob_id};
use host_sim::can::client::ClientError;
use host_sim::can::fault_history::PastError;
use host_sim::can::link::{Link, open_split};
use host_sim::can::telemetry::Telemetry;

use crate::attach;
use crate::bus::decode::{decode, nmt_state};
use crate::core::{Core, State};
use crate::motion;
use crate::node::Node;
use crate::quantity;

/// Time after which a bus that was lost is opened again.
const RETRY: Duration = Duration::from_millis(500);

/// Time after which `stop` is detected on an idle bus.
const PATIENCE: Duration = Duration::from_millis(100);

/// Receives until `stop` is set. The bus is open already the first time.
pub fn run(core: &Arc<Core>, bus: &str, first: Box<dyn Link + Send>, stop: &AtomicBool) {
    let mut link = Some(first);
    while !stop.load(Relaxed) {
        let Some(open) = &mut link else {
            std::thread::sleep(RETRY);
            link = reopen(core, bus);
            continue;
        };
        match open.receive(PATIENCE) {
            Ok(Some(frame)) => receive(core, &frame),
            Ok(None) => {}
            Err(error) => {
                link = None;
                lose(core, &error.to_string());
            }
        }
        for frame in core.hub.take_sent() {
            let now_s = core.now_s();
            core.with(|state| count(state, &frame, now_s));
        }
    }
}

fn lose(core: &Core, why: &str) {
    core.hub.connect(None);
    core.with(|state| {
        state.bus_problem = Some(why.to_owned());
        state.has_changed = true;
    });
    core.log("fault", None, &format!("the bus is disconnected: {why}"));
}

fn reopen(core: &Arc<Core>, bus: &str) -> Option<Box<dyn Link + Send>> {
    let split = open_split(bus, core.kbit_s).ok()?;
    core.hub.connect(Some(split.transmitter));
    core.with(|state| {
        state.bus_problem = None;
        state.has_changed = true;
        for node in state.nodes.values_mut() {
            node.is_attached = false;
        }
    });
    core.log("info", None, "the bus is back");
    // Refused if too many tasks run: the user can then start the search from the page.
    let _ = core.spawn(|core, task| attach::scan(core, &task));
    Some(split.receiver)
}

fn count(state: &mut State, frame: &CanFrame, now_s: f64) {
    let State {
        statistics, nodes, ..
    } = state;
    statistics.count(frame, now_s, || {
        decode(frame, |frame| {
            let node = nodes.get(&((frame.raw_id().0 & 0x7F) as u8))?;
            node.telemetry.as_ref()?.text(frame)
        })
    });
}

fn receive(core: &Arc<Core>, frame: &CanFrame) {
    core.hub.deliver(frame);
    let now_s = core.now_s();
    core.with(|state| count(state, frame, now_s));
    let (id, is_extended) = frame.raw_id();
    let (function, node) = cob_id::split(id);
    match function {
        _ if is_extended || node == 0 => {}
        cob_id::HEARTBEAT if node == motion::OWN_NODE => shared(core),
        cob_id::HEARTBEAT => heartbeat(core, node, frame.bytes()[0] & 0x7F),
        cob_id::EMERGENCY => emergency(core, node, frame),
        _ if (cob_id::tpdo(1)..=cob_id::rpdo(4)).contains(&function) => {
            sample(core, node, frame, now_s);
        }
        _ => {}
    }
}

/// A heartbeat of another program with the node-ID of this one: it would go on if this program
/// ended, and its actuators would not stop.
fn shared(core: &Arc<Core>) {
    let (is_new, moving) = core.with(|state| {
        let is_new = state.shared.replace(Instant::now()).is_none();
        let nodes = state.nodes.iter();
        let moving = nodes.filter(|(_, node)| node.moved_by().is_some());
        (is_new, moving.map(|(node, _)| *node).collect::<Vec<_>>())
    });
    if is_new || !moving.is_empty() {
        let error = ClientError::SharedNode(motion::OWN_NODE);
        core.log("fault", None, &error.to_string());
    }
    for node in moving {
        motion::stop(core, node);
    }
}

/// A heartbeat or a boot-up message.
fn heartbeat(core: &Arc<Core>, number: u8, nmt: u8) {
    let (is_new, was_lost, before) = core.with(|state| {
        let is_new = !state.nodes.contains_key(&number);
        let node = state.nodes.entry(number).or_default();
        node.device.node = number;
        node.heartbeat = Some(Instant::now());
        let was_lost = std::mem::take(&mut node.is_lost);
        let before = node.nmt.replace(nmt);
        if nmt == 0 {
            (node.is_attached, node.enabled_by, node.statusword) = (false, None, None);
            node.is_watching = false;
        }
        state.has_changed |= is_new || was_lost || before != Some(nmt);
        (is_new, was_lost, before)
    });
    if was_lost {
        core.log("info", Some(number), "its heartbeat is back");
    }
    if nmt == 0 {
        core.log("info", Some(number), "has started");
    } else if before.is_some_and(|before| before != nmt && before != 0) {
        core.log("info", Some(number), &format!("is now {}", nmt_state(nmt)));
    }
    if is_new || nmt == 0 {
        attach::request(core, number);
    }
}

/// An EMCY message.
fn emergency(core: &Arc<Core>, number: u8, frame: &CanFrame) {
    let data = frame.bytes();
    let error = PastError::of_word(u32::from_le_bytes([data[0], data[1], data[3], data[4]]));
    match error.error_code {
        0 => core.log("info", Some(number), "its errors are reset"),
        _ => {
            let text = format!("error {} {}", error.code(), error.what());
            core.log("fault", Some(number), &text);
        }
    }
    attach::refresh_faults(core, number);
}

fn sample(core: &Arc<Core>, number: u8, frame: &CanFrame, now_s: f64) {
    let change = core.with(|state| {
        let nodes = state.nodes.len();
        let node = state.nodes.get_mut(&number)?;
        let telemetry = node.telemetry.as_mut()?;
        if !telemetry.receive(frame) {
            return None;
        }
        let counter = telemetry.value("sample_counter").map(|value| value as u16);
        let values = quantity::values(telemetry);
        node.mode = telemetry
            .value("modes_of_operation_display")
            .map_or(0, |mode| mode as i8);
        let statusword = telemetry.value("statusword").map(|word| word as u16);
        node.record.push(counter, now_s, values, nodes);
        let change = of_state(node, statusword);
        state.has_changed |= change.is_some();
        change
    });
    if let Some(change) = change {
        let kind = if change.has_fault { "fault" } else { "info" };
        core.log(kind, Some(number), change.state);
        if change.has_fault || change.had_fault {
            attach::refresh_faults(core, number);
        }
        if change.is_released {
            attach::release(core, number);
        }
    }
}

/// A change of the drive's state.
struct Change {
    state: &'static str,
    has_fault: bool,
    had_fault: bool,
    /// The drive is off that was enabled from a page.
    is_released: bool,
}

fn of_state(node: &mut Node, statusword: Option<u16>) -> Option<Change> {
    let (before, had_fault, was_powered) = (node.state(), node.has_fault(), node.is_powered());
    node.statusword = statusword.or(node.statusword);
    let state = node.state()?;
    if before == Some(state) {
        return None;
    }
    let is_released = was_powered && !node.is_powered();
    if is_released {
        (node.enabled_by, node.is_stopping, node.target) = (None, false, None);
    }
    Some(Change {
        state,
        has_fault: node.has_fault(),
        had_fault,
        is_released,
    })
}

/// The text of a TPDO.
trait Text {
    fn text(&self, frame: &CanFrame) -> Option<String>;
}

impl Text for Telemetry {
    fn text(&self, frame: &CanFrame) -> Option<String> {
        let content = self.content(frame)?;
        let content: Vec<_> = content
            .iter()
            .map(|(name, value)| format!("{name} {value}"))
            .collect();
        Some(content.join(", "))
    }
}
