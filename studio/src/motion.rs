//! Motions on request of a page, and what ends them.
//!
//! Three things end a motion, each where the one before has failed:
//!
//! 1. A stop: any page may request it, at any time. The quick stop is sent at once, beside all
//!    other work, and again until the drive is off.
//! 2. The page that requested the motion is closed, or does not answer for [`PAGE_SILENT`]: this
//!    program stops the drive as for 1.
//! 3. This program has ended, or the bus has failed: the actuator monitors its heartbeat (1016h)
//!    while it is enabled, and reacts according to 2040h:2.
//!
//! Servos of a serial bus are halted by the thread of the bus, before its other work.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use canopen::{CanFrame, cob_id};
use host_sim::can::client::{Client, ClientError};
use host_sim::can::mapped;

use crate::attach;
use crate::core::{Busy, Core};
use crate::node::Target;
use crate::web::PageId;

/// Time without a sign of life of a page after which its motions are stopped.
pub const PAGE_SILENT: Duration = Duration::from_millis(700);

/// Node-ID of this program: the highest, which has the lowest priority.
pub const OWN_NODE: u8 = 127;

/// Period of the heartbeat of this program while a drive is enabled.
pub const HEARTBEAT: Duration = Duration::from_millis(50);

/// Time for which the node-ID of this program counts as that of another one after its heartbeat.
const SHARED: Duration = Duration::from_millis(300);

/// Time without it after which an actuator reacts, ms.
pub const HEARTBEAT_TIMEOUT_MS: u32 = 300;

/// Mode of operation (6060h): an angle, reached by a profile.
pub const PROFILE_POSITION: i8 = 1;

/// Mode of operation: a rate, reached by a ramp.
const PROFILE_VELOCITY: i8 = 3;

/// Controlword: quick stop (CiA 402).
const QUICK_STOP: u16 = canopen::cia402::controlword::ENABLE_VOLTAGE;

/// Mode of operation: a torque, reached by a slope.
const PROFILE_TORQUE: i8 = 4;

/// The frame that writes the controlword of a node: an expedited download, which the node takes in
/// any state and in the middle of any other transfer.
fn controlword(node: u8, word: u16) -> CanFrame {
    let [low, high] = word.to_le_bytes();
    let id = cob_id::of_node(cob_id::SDO_REQUEST, node);
    CanFrame::received(id.into(), false, 8, [0x2B, 0x40, 0x60, 0, low, high, 0, 0])
}

/// The heartbeat of this program: operational.
fn heartbeat() -> Option<CanFrame> {
    embedded_can::Frame::new(cob_id::of_node(cob_id::HEARTBEAT, OWN_NODE), &[5])
}

/// Enables the drive in profile position mode, watching this program's heartbeat.
///
/// # Errors
/// Those of the transfers and of the drive.
pub fn enable(core: &Arc<Core>, client: &mut Client, page: PageId) -> Result<(), ClientError> {
    let number = client.node();
    let is_shared = core.with(|state| {
        let last = state.shared;
        last.is_some_and(|last| last.elapsed() < SHARED)
    });
    if is_shared {
        return Err(ClientError::SharedNode(OWN_NODE));
    }
    let watch = u32::from(OWN_NODE) << 16 | HEARTBEAT_TIMEOUT_MS;
    client.write("1016:1", "0")?;
    client.write("1016:1", &watch.to_string())?;
    // The heartbeat starts with this.
    core.with_node(number, |node| {
        (node.enabled_by, node.is_watching) = (Some(page), true)
    });
    let enabled = client.enable(PROFILE_POSITION);
    if enabled.is_err() {
        core.with_node(number, |node| node.enabled_by = None);
        attach::release(core, number);
    }
    enabled
}

/// Commands the angle, rate or torque that was last requested.
///
/// # Errors
/// Those of the transfers and of the drive.
pub fn go(core: &Core, client: &mut Client) -> Result<(), ClientError> {
    let target = core.with_node(client.node(), |node| node.target.take());
    match target.flatten() {
        Some(Target::Angle(mdeg)) => {
            take_mode(core, client, PROFILE_POSITION)?;
            client.move_to(mdeg)
        }
        Some(Target::Rate(mdeg_s)) => {
            take_mode(core, client, PROFILE_VELOCITY)?;
            client.write("60FF", &mdeg_s.to_string())
        }
        Some(Target::Torque(micro_nm)) => {
            let permille = permille_of_rated(client, micro_nm)?;
            take_mode(core, client, PROFILE_TORQUE)?;
            client.write("6071", &permille.to_string())
        }
        // An earlier job has commanded a later target already.
        None => Ok(()),
    }
}

/// A torque, uN m, in thousandths of the rated torque of the actuator.
fn permille_of_rated(client: &mut Client, micro_nm: i32) -> Result<i16, ClientError> {
    // mN m: a thousandth of it is as many uN m.
    let rated = client.integer("6076")? as f64;
    let permille = (f64::from(micro_nm) / rated).round();
    // Not for a rated torque of 0 either.
    if permille.abs() <= f64::from(i16::MAX) {
        return Ok(permille as i16);
    }
    Err(ClientError::NotNow {
        node: client.node(),
        why: "expected a torque that 6071h holds in thousandths of the rated torque 6076h",
    })
}

/// Changes the mode of an enabled drive where it is another one, and waits for it: a target acts
/// once its mode has started.
///
/// # Errors
/// Those of the transfers, and a mode that does not start.
pub fn take_mode(core: &Core, client: &mut Client, mode: i8) -> Result<(), ClientError> {
    const PATIENCE: Duration = Duration::from_secs(1);
    let shown = core.with_node(client.node(), |node| node.mode);
    if shown == Some(mode) {
        return Ok(());
    }
    client.write("6060", &mode.to_string())?;
    let end = Instant::now() + PATIENCE;
    while client.integer("6061")? != i64::from(mode) {
        if Instant::now() > end {
            return client.fail_in_state("expected the mode to start");
        }
        client.pause(Duration::from_millis(4))?;
    }
    core.with_node(client.node(), |node| node.mode = mode);
    Ok(())
}

/// Stops a drive: at once, and until it is off.
pub fn stop(core: &Arc<Core>, number: u8) {
    let is_there = core.with_node(number, |node| {
        // Whether the torque of a servo is on is read before its motion ends.
        let is_moving = node.is_powered() || node.moved_by().is_some();
        node.is_stopping |= is_moving || node.servo.is_some();
        node.stops.fetch_add(1, Ordering::SeqCst);
        node.target = None;
        node.is_actuator
    });
    if is_there == Some(true) {
        // Without a bus the actuator stops without a command.
        let _ = core.hub.send(&controlword(number, QUICK_STOP));
    }
}

/// Stops all drives.
pub fn stop_all(core: &Arc<Core>) {
    let actuators = core.with(|state| {
        let nodes = state.nodes.iter();
        let actuators = nodes.filter(|(_, node)| node.is_actuator || node.servo.is_some());
        actuators.map(|(number, _)| *number).collect::<Vec<_>>()
    });
    for node in actuators {
        stop(core, node);
    }
}

/// Supervises the motions; called every few milliseconds.
pub struct Supervisor {
    next_heartbeat: Instant,
    next_repetition: Instant,
}

/// Time after which a stop is sent again to a drive that is not off.
const REPETITION: Duration = Duration::from_millis(50);

impl Supervisor {
    /// From now on.
    pub fn new(now: Instant) -> Self {
        Self {
            next_heartbeat: now,
            next_repetition: now,
        }
    }

    /// Stops motions of pages that are gone or silent, repeats stops, and sends the heartbeat.
    pub fn tick(&mut self, core: &Arc<Core>, now: Instant) {
        for (number, page) in orphans(core, now) {
            let why = match page {
                PageFate::Gone => "its page is closed",
                PageFate::Silent => "its page does not answer",
            };
            core.log("warning", Some(number), &format!("stopped: {why}"));
            stop(core, number);
        }
        if now >= self.next_repetition {
            self.next_repetition = now + REPETITION;
            self.repeat(core);
        }
        let is_needed = || core.with(|state| state.nodes.values().any(|n| n.is_watching));
        if now >= self.next_heartbeat && is_needed() {
            self.next_heartbeat = now + HEARTBEAT;
            if let Some(frame) = heartbeat() {
                // Without a bus the actuator misses it, as it shall.
                let _ = core.hub.send(&frame);
            }
        }
    }

    fn repeat(&self, core: &Arc<Core>) {
        let (mut moving, mut off) = (Vec::new(), Vec::new());
        core.with(|state| {
            let nodes = state.nodes.iter_mut();
            // Servos are halted by the thread of their bus.
            for (number, node) in nodes.filter(|(_, it)| it.is_stopping && it.servo.is_none()) {
                if node.is_enabled() {
                    moving.push(*number);
                } else if !node.is_powered() {
                    (node.is_stopping, node.enabled_by) = (false, None);
                    off.push(*number);
                }
                // A quick stop that is under way needs no other.
            }
            state.has_changed |= !off.is_empty();
        });
        for number in moving {
            // Without a bus the actuator stops without a command.
            let _ = core.hub.send(&controlword(number, QUICK_STOP));
        }
        off.into_iter()
            .for_each(|number| attach::release(core, number));
    }
}

/// What became of a page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum PageFate {
    Gone,
    Silent,
}

/// The drives that are moved by a page which is closed or silent, and are not stopped yet.
fn orphans(core: &Core, now: Instant) -> Vec<(u8, PageFate)> {
    core.with(|state| {
        let pages = &state.pages;
        let fate = |page| match pages.get(&page) {
            None => Some(PageFate::Gone),
            Some(state) if now.duration_since(state.alive) > PAGE_SILENT => Some(PageFate::Silent),
            Some(_) => None,
        };
        let nodes = state.nodes.iter();
        let nodes = nodes.filter(|(_, node)| !node.is_stopping);
        nodes
            .filter_map(|(number, node)| Some((*number, fate(node.moved_by()?)?)))
            .collect()
    })
}

/// Leaves all actuators as they were found, when the program ends.
pub fn leave(core: &Arc<Core>) {
    stop_all(core);
    let nodes = core.with(|state| {
        let nodes = state.nodes.iter_mut();
        nodes
            .map(|(number, node)| (*number, std::mem::take(&mut node.original)))
            .collect::<Vec<_>>()
    });
    let (done, all_done) = std::sync::mpsc::channel();
    for (number, original) in nodes
        .into_iter()
        .filter(|(_, original)| !original.is_empty())
    {
        let done = done.clone();
        let restored = core.at_node(number, move |client| {
            // A lost node restores its settings with its next start.
            let _ = client.write("1016:1", "0");
            let _ = mapped::restore(client, &original);
            let _ = done.send(());
        });
        if let Err(Busy) = restored {
            core.log(
                "warning",
                Some(number),
                "keeps its telemetry: it has too much to do",
            );
        }
    }
    drop(done);
    /// Longest wait after an interrupt: a user expects the program to end within seconds.
    const PATIENCE: Duration = Duration::from_secs(2);
    let end = Instant::now() + PATIENCE;
    while all_done
        .recv_timeout(end.saturating_duration_since(Instant::now()))
        .is_ok()
    {}
}
