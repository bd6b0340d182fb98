//! The state that all threads share, and the threads' access to it.
//!
//! | thread | does |
//! |---|---|
//! | server | pages: files, messages, requests |
//! | receiver | frames of the bus: samples, states, statistics |
//! | clock | every 10 ms: samples to the pages, supervision of motions, heartbeat |
//! | one of each node | transfers of objects, in order |
//! | one of each task | scan, identification and other long work |
//!
//! The state is locked for a moment at a time; no thread waits for a node while it is locked.

use std::collections::{BTreeMap, VecDeque};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{self, SyncSender, TrySendError};
use std::sync::{Arc, Mutex};
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use canopen::cob_id;
use host_sim::can::client::Client;
use serde_json::{Value, json};

use crate::bus::hub::{Hub, lock};
use crate::bus::statistics::Statistics;
use crate::control::Control;
use crate::guarded::{Guard, GuardedLink};
use crate::neighbours::Neighbour;
use crate::node::Node;
use crate::servos::Servos;
use crate::web::{Download, PageId, Pages};

/// Jobs that wait for a node.
const JOBS: usize = 64;

/// Tasks at a time.
const TASKS: usize = 6;

/// Entries of the log that new pages get.
const LOG: usize = 300;

/// Files that wait to be downloaded.
const FILES: usize = 4;

/// Work for a node, with a client for it.
type Job = Box<dyn FnOnce(&mut Client) + Send>;

/// A page.
#[derive(Debug)]
pub struct PageState {
    /// Time of its last sign of life.
    pub alive: Instant,
}

/// What changes.
#[derive(Default)]
pub struct State {
    /// The nodes by their node-IDs.
    pub nodes: BTreeMap<u8, Node>,
    /// The frames of the bus.
    pub statistics: Statistics,
    /// Who commands.
    pub control: Control,
    /// The pages.
    pub pages: BTreeMap<PageId, PageState>,
    /// Why there is no bus.
    pub bus_problem: Option<String>,
    /// The log.
    pub log: VecDeque<Value>,
    /// The image of the next update, as far as it was sent.
    pub image: Vec<u8>,
    /// Files for the user: the newest last.
    files: VecDeque<Download>,
    /// Long work that can be stopped.
    tasks: BTreeMap<u64, Arc<AtomicBool>>,
    /// The nodes have changed since they were sent to the pages.
    pub has_changed: bool,
    /// Other Studios on this computer.
    pub neighbours: Vec<Neighbour>,
    /// When a heartbeat of another program with the node-ID of this one was last received.
    pub shared: Option<Instant>,
}

/// The state and the ways out of it.
pub struct Core {
    /// The bus.
    pub hub: Arc<Hub>,
    /// The thread of the servos, if the bus has some in place of CAN.
    pub servos: Option<Servos>,
    /// The pages.
    pub pages: Pages,
    state: Mutex<State>,
    workers: Mutex<BTreeMap<u8, SyncSender<Job>>>,
    start: Instant,
    next_task: AtomicU64,
    /// Bit rate of the bus, kbit/s.
    pub kbit_s: u16,
    /// Switches that break the encoders of simulated actuators, by node-IDs from 1.
    pub encoder_switches: Vec<Arc<AtomicBool>>,
    /// Gets each entry of the log.
    notify: Box<dyn Fn(&str) + Send + Sync>,
}

/// A request finds no room.
#[derive(Debug, Clone, Copy, thiserror::Error)]
#[error("too much is waiting already; try again in a moment")]
pub struct Busy;

impl Core {
    /// Without nodes.
    pub fn new(
        pages: Pages,
        kbit_s: u16,
        encoder_switches: Vec<Arc<AtomicBool>>,
        notify: Box<dyn Fn(&str) + Send + Sync>,
    ) -> Self {
        Self {
            hub: Arc::default(),
            servos: None,
            pages,
            state: Mutex::default(),
            workers: Mutex::default(),
            start: Instant::now(),
            next_task: AtomicU64::new(1),
            kbit_s,
            encoder_switches,
            notify,
        }
    }

    /// The state. No other lock is taken before it is released, except that of the bus.
    pub fn with<T>(&self, change: impl FnOnce(&mut State) -> T) -> T {
        change(&mut lock(&self.state))
    }

    /// Changes a node, if it is there.
    pub fn with_node<T>(&self, node: u8, change: impl FnOnce(&mut Node) -> T) -> Option<T> {
        self.with(|state| {
            state.has_changed = true;
            state.nodes.get_mut(&node).map(change)
        })
    }

    /// Time since the start of the program, s.
    pub fn now_s(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// Writes to the log, which all pages show. `kind` is `info`, `warning` or `fault`.
    pub fn log(&self, kind: &'static str, node: Option<u8>, text: &str) {
        let at = SystemTime::now().duration_since(UNIX_EPOCH);
        let entry = json!({
            "event": "log", "kind": kind, "node": node, "text": text,
            "at_ms": at.map_or(0, |at| at.as_millis() as u64),
        });
        self.pages.tell_all(&entry);
        self.with(|state| {
            if state.log.len() == LOG {
                state.log.pop_front();
            }
            state.log.push_back(entry);
        });
        let noun = if self.servos.is_some() {
            "servo"
        } else {
            "node"
        };
        let node = node.map_or_else(String::new, |node| format!("{noun} {node}: "));
        (self.notify)(&format!("{node}{text}"));
    }

    /// Does work with a client of a node, after all other work for it.
    ///
    /// # Errors
    /// [`Busy`].
    pub fn at_node(
        self: &Arc<Self>,
        node: u8,
        job: impl FnOnce(&mut Client) + Send + 'static,
    ) -> Result<(), Busy> {
        let mut workers = lock(&self.workers);
        let worker = workers
            .entry(node)
            .or_insert_with(|| self.start_worker(node));
        match worker.try_send(Box::new(job)) {
            Ok(()) => Ok(()),
            Err(TrySendError::Full(_)) => Err(Busy),
            // A job before it has panicked.
            Err(TrySendError::Disconnected(job)) => {
                *worker = self.start_worker(node);
                worker.try_send(job).map_err(|_| Busy)
            }
        }
    }

    fn start_worker(self: &Arc<Self>, node: u8) -> SyncSender<Job> {
        let (sender, jobs) = mpsc::sync_channel::<Job>(JOBS);
        let hub = Arc::clone(&self.hub);
        std::thread::spawn(move || {
            for job in jobs {
                let response = cob_id::SDO_RESPONSE + u32::from(node);
                job(&mut Client::new(
                    Box::new(hub.link(response..=response)),
                    node,
                ));
            }
        });
        sender
    }

    /// What ends work that is requested now at the next stop of the node.
    pub fn guard(&self, node: u8) -> Guard {
        let stops = self.with_node(node, |node| Arc::clone(&node.stops));
        Guard::new(stops.unwrap_or_default())
    }

    /// Like [`Core::at_node`], for work that moves the shaft: a stop ends it.
    ///
    /// # Errors
    /// [`Busy`].
    pub fn move_at_node(
        self: &Arc<Self>,
        node: u8,
        job: impl FnOnce(&mut Client) + Send + 'static,
    ) -> Result<(), Busy> {
        let guard = self.guard(node);
        let hub = Arc::clone(&self.hub);
        self.at_node(node, move |client| {
            let response = cob_id::SDO_RESPONSE + u32::from(client.node());
            let link = GuardedLink::new(hub.link(response..=response), guard);
            job(&mut Client::new(Box::new(link), client.node()));
        })
    }

    /// Does long work in its own thread; the flag requests its end.
    ///
    /// # Errors
    /// [`Busy`].
    pub fn spawn(
        self: &Arc<Self>,
        work: impl FnOnce(&Arc<Self>, Task) + Send + 'static,
    ) -> Result<u64, Busy> {
        let number = self.next_task.fetch_add(1, Ordering::Relaxed);
        let stop = Arc::new(AtomicBool::new(false));
        let is_there = self.with(|state| {
            let has_room = state.tasks.len() < TASKS;
            if has_room {
                state.tasks.insert(number, Arc::clone(&stop));
            }
            has_room
        });
        if !is_there {
            return Err(Busy);
        }
        let core = Arc::clone(self);
        std::thread::spawn(move || {
            let task = Task {
                number,
                stop,
                pages: core.pages.clone(),
            };
            let _end = EndOfTask(Arc::clone(&core), number);
            work(&core, task);
        });
        Ok(number)
    }

    /// Requests the end of long work.
    pub fn cancel(&self, task: u64) {
        self.with(|state| {
            if let Some(stop) = state.tasks.get(&task) {
                stop.store(true, Ordering::Relaxed);
            }
        });
    }

    /// Keeps a file until it is downloaded; returns the name in its address.
    pub fn offer(&self, name: &str, bytes: Vec<u8>) -> String {
        let file = Download {
            name: name.to_owned(),
            bytes,
        };
        self.with(|state| {
            if state.files.len() == FILES {
                state.files.pop_front();
            }
            state.files.push_back(file);
        });
        format!("/files/{name}")
    }

    /// Gives a file away.
    pub fn take_file(&self, name: &str) -> Option<Download> {
        self.with(|state| {
            let at = state.files.iter().rposition(|file| file.name == name)?;
            state.files.remove(at)
        })
    }
}

/// Long work.
#[derive(Clone)]
pub struct Task {
    /// Its number.
    pub number: u64,
    stop: Arc<AtomicBool>,
    pages: Pages,
}

impl Task {
    /// Whether its end is requested.
    pub fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// The flag that requests its end.
    pub fn end(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.stop)
    }

    /// Reports the progress to the pages.
    pub fn progress(&self, what: &str, done: usize, of: usize) {
        self.pages.tell_all(&json!({
            "event": "progress", "task": self.number, "what": what, "done": done, "of": of,
        }));
    }
}

/// Reports to the pages that a task has ended, also when it has failed.
struct EndOfTask(Arc<Core>, u64);

impl Drop for EndOfTask {
    fn drop(&mut self) {
        self.0.with(|state| state.tasks.remove(&self.1));
        self.0
            .pages
            .tell_all(&json!({ "event": "progress", "task": self.1, "ended": true }));
    }
}
