//! The thread that owns the port.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use host_sim::servo_bus::client::{Client, Device, IDS, ServoError};
use serde_json::json;
use servo_bus::Order;

use super::changes::{abandon, answer, attach, missed, numbers, take, take_state};
use super::{Job, Servos};
use crate::core::Core;
use crate::node::Node;

/// Shortest time between two samples: that for which pages have memory.
const PERIOD: Duration = Duration::from_millis(4);

/// Time between two reads of the state of a servo, one register at a time.
const STATE: Duration = Duration::from_millis(20);

/// Time between two probes of missing servos, each of which delays the samples by 25 ms.
const PROBE: Duration = Duration::from_millis(500);

/// IDs that are probed twice, and longer, as an answer is late where the processor is busy:
/// most servos have one of these.
const USUAL: u8 = 20;

/// Time after which a bus that was lost is opened again.
const RETRY: Duration = Duration::from_millis(500);

/// Attempts to end the motions at the end of the program.
const LAST_STOPS: usize = 3;

/// Runs until `ended` is set, then ends the motions that are to be ended. The bus is open already
/// the first time.
pub fn run(core: &Arc<Core>, bus: &str, first: Client, jobs: &Receiver<Job>, ended: &AtomicBool) {
    let Some(servos) = &core.servos else { return };
    let mut line = Some(Line::new(first));
    while !ended.load(Relaxed) {
        let Some(open) = &mut line else {
            refuse(jobs, RETRY);
            line = reopen(core, servos, bus);
            continue;
        };
        if let Err(error) = open.turn(core, servos, jobs) {
            line = None;
            lose(core, &error.to_string());
        }
    }
    if let Some(open) = &mut line {
        for _ in 0..LAST_STOPS {
            // The program ends also without a bus.
            let _ = open.end_motions(core);
        }
    }
}

/// Answers what is requested within this time.
fn refuse(jobs: &Receiver<Job>, time: Duration) {
    let end = Instant::now() + time;
    while let Ok(job) = jobs.recv_timeout(end.saturating_duration_since(Instant::now())) {
        job(Err("the bus is disconnected".into()));
    }
}

fn lose(core: &Core, why: &str) {
    core.with(|state| {
        state.bus_problem = Some(why.to_owned());
        state.has_changed = true;
        state.nodes.values_mut().for_each(abandon);
    });
    core.log("fault", None, &format!("the bus is disconnected: {why}"));
}

fn reopen(core: &Core, servos: &Servos, bus: &str) -> Option<Line> {
    let client = Client::open(bus).ok()?;
    core.with(|state| {
        state.bus_problem = None;
        state.has_changed = true;
    });
    core.log("info", None, "the bus is back");
    servos.scan();
    Some(Line::new(client))
}

/// The result of a write; a servo that answers reads only carries it out without an answer.
fn unless_silent(
    client: &mut Client,
    device: Device,
    written: Result<(), ServoError>,
) -> Result<(), ServoError> {
    if !matches!(written, Err(ServoError::NoAnswer(_))) {
        return written;
    }
    match device.require_answers(client) {
        Err(ServoError::Silent { .. }) => Ok(()),
        _ => written,
    }
}

/// The bytes that servos are read for a sample: first address, their number and order.
type Block = (u16, u8, bool);

struct Line {
    client: Client,
    next_sample: Instant,
    next_state: Instant,
    next_probe: Instant,
    /// Counts the reads of a state.
    states: usize,
    /// Counts the probes of missing servos.
    probes: usize,
    /// Servos that refuse to be stopped, which is logged once.
    refusing: BTreeSet<u8>,
}

impl Line {
    fn new(client: Client) -> Self {
        let now = Instant::now();
        Self {
            client,
            next_sample: now,
            next_state: now,
            next_probe: now,
            states: 0,
            probes: 0,
            refusing: BTreeSet::new(),
        }
    }

    /// What is due, with one job at most.
    fn turn(
        &mut self,
        core: &Arc<Core>,
        servos: &Servos,
        jobs: &Receiver<Job>,
    ) -> Result<(), ServoError> {
        self.end_motions(core)?;
        let pause = self.next_sample.saturating_duration_since(Instant::now());
        match jobs.recv_timeout(pause) {
            Ok(job) => job(Ok(&mut self.client)),
            Err(RecvTimeoutError::Timeout) => {}
            // Not while the state has the other end.
            Err(RecvTimeoutError::Disconnected) => std::thread::sleep(PERIOD),
        }
        let now = Instant::now();
        if now >= self.next_sample {
            self.next_sample = now + PERIOD;
            self.sample(core)?;
        }
        // A scan takes seconds, in which the state may change.
        if now >= self.next_state {
            self.next_state = now + STATE;
            self.read_state(core)?;
        } else if let Some(id) = servos.next_probe() {
            self.probe(core, id)?;
            servos.has_probed(id);
            core.pages.tell_all(&json!({
                "event": "progress", "task": 0, "what": "IDs", "done": id, "of": IDS.end(),
                "ended": servos.next_probe().is_none(),
            }));
        } else if now >= self.next_probe {
            self.next_probe = now + PROBE;
            let missing = numbers(core, |node| node.is_lost);
            if !missing.is_empty() {
                self.probes += 1;
                self.probe(core, missing[self.probes % missing.len()])?;
            }
        }
        Ok(())
    }

    /// Ends the motions that are to be ended, first those that a page has commanded.
    fn end_motions(&mut self, core: &Core) -> Result<(), ServoError> {
        let mut stopping = core.with(|state| {
            let nodes = state.nodes.iter();
            let nodes = nodes.filter(|(_, node)| node.is_stopping && !node.is_lost);
            let servos = nodes.filter_map(|(number, node)| {
                let servo = node.servo.as_ref()?;
                Some((
                    node.enabled_by.is_none(),
                    *number,
                    servo.device,
                    servo.is_watched,
                ))
            });
            servos.collect::<Vec<_>>()
        });
        stopping.sort_by_key(|(is_later, ..)| *is_later);
        for (_, number, device, is_watched) in stopping {
            let is_off = match self.halt(device, is_watched) {
                Ok(is_off) => is_off,
                Err(error @ ServoError::Bus { .. }) => return Err(error),
                // Again, until it counts as missing.
                Err(ServoError::NoAnswer(_)) => {
                    missed(core, number);
                    continue;
                }
                // Again: it may have been noise.
                Err(error) => {
                    if self.refusing.insert(number) {
                        core.log("fault", Some(number), &format!("is not stopped: {error}"));
                    }
                    continue;
                }
            };
            self.refusing.remove(&number);
            core.with_node(number, |node| {
                (node.is_stopping, node.enabled_by) = (false, None);
                if let Some(servo) = &mut node.servo {
                    servo.is_watched = false;
                    servo.is_torque_on &= !is_off;
                }
            });
        }
        Ok(())
    }

    /// Ends a motion; returns whether the torque is off, and so nothing moves.
    fn halt(&mut self, device: Device, is_watched: bool) -> Result<bool, ServoError> {
        let client = &mut self.client;
        // A goal would turn the torque of an STS on.
        if !device.is_driven(client)? {
            return Ok(true);
        }
        let mut halted = device.halt(client);
        if is_watched && matches!(halted, Err(ServoError::Refused { .. })) {
            // Behind an expired bus watchdog, which has stopped it, a Dynamixel refuses goals.
            device.write(client, "bus_watchdog", 0)?;
            halted = device.halt(client);
        }
        unless_silent(client, device, halted)?;
        if is_watched {
            let written = device.write(client, "bus_watchdog", 0);
            unless_silent(client, device, written)?;
        }
        Ok(false)
    }

    /// A sample of all servos.
    fn sample(&mut self, core: &Core) -> Result<(), ServoError> {
        let blocks = core.with(|state| {
            let mut blocks = BTreeMap::<Block, Vec<u8>>::new();
            for (number, node) in state.nodes.iter().filter(|(_, node)| !node.is_lost) {
                if let Some(servo) = &node.servo {
                    let columns = &servo.columns;
                    let is_high_first = servo.device.table.order == Order::Big;
                    let block = (columns.first, columns.length, is_high_first);
                    blocks.entry(block).or_default().push(*number);
                }
            }
            blocks
        });
        for ((first, length, is_high_first), ids) in blocks {
            let from_s = core.now_s();
            let answers = if is_high_first {
                let each = ids
                    .iter()
                    .map(|id| answer(self.client.read_bytes(*id, first, length)));
                each.collect::<Result<_, _>>()?
            } else {
                self.client.sync_read(&ids, first, length)?
            };
            let step_s = (core.now_s() - from_s) / ids.len() as f64;
            for (place, (id, bytes)) in ids.iter().zip(answers).enumerate() {
                // The servos answer in turn.
                let at_s = from_s + (place as f64 + 0.5) * step_s;
                match bytes {
                    Some(bytes) => core.with(|state| take(state, *id, at_s, &bytes)),
                    None => missed(core, *id),
                }
            }
        }
        Ok(())
    }

    /// Attaches a servo with this ID that is not known, or missing, if there is one.
    fn probe(&mut self, core: &Core, id: u8) -> Result<(), ServoError> {
        let is_there = core.with(|state| state.nodes.get(&id).is_some_and(|node| !node.is_lost));
        if is_there {
            return Ok(());
        }
        let mut found = answer(self.client.probe(id))?.flatten();
        if found.is_none() && id <= USUAL {
            found = answer(self.client.table(id))?;
        }
        match found {
            Some(table) => attach(core, &mut self.client, id, table),
            None => Ok(()),
        }
    }

    /// Reads the torque or the errors of the next servo.
    fn read_state(&mut self, core: &Core) -> Result<(), ServoError> {
        let present = numbers(core, |node| !node.is_lost && node.servo.is_some());
        if present.is_empty() {
            return Ok(());
        }
        self.states += 1;
        let number = present[self.states / 2 % present.len()];
        let device = core.with(|state| Some(state.nodes.get(&number)?.servo.as_ref()?.device));
        let Some(device) = device else { return Ok(()) };
        let is_torque = self.states.is_multiple_of(2);
        let name = match is_torque {
            true => "torque_enable",
            false => device.error_register()?.name,
        };
        let Some(value) = answer(device.read(&mut self.client, name))? else {
            return Ok(());
        };
        let (change, is_watched) = core.with(|state| take_state(state, number, is_torque, value));
        if is_watched && answer(device.write(&mut self.client, "bus_watchdog", 0))?.is_some() {
            let off = |node: &mut Node| node.servo.iter_mut().for_each(|it| it.is_watched = false);
            core.with_node(number, off);
        }
        if let Some((kind, text)) = change {
            core.log(kind, Some(number), &text);
        }
        Ok(())
    }
}
