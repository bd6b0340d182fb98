//! Studio: a page in a browser that shows, moves, tunes and identifies actuators on a CAN bus, or
//! shows and moves servos on a serial bus.
//!
//! [`Studio`] serves the page on a port of this computer and talks to the bus. The page has no
//! state of its own: several pages show the same, and one of them commands.
//!
//! ```text
//! page ── WebSocket ── web ── requests ── core ──┬── one thread a node ── SDO ──┐
//!                                                ├── clock, motion ── heartbeat ├── bus
//!                                                └── receiver ◀── telemetry ────┘
//! ```
//!
//! It is its own crate because the simulator is used without it: bindings and tests need no
//! server for browsers.

mod attach;
mod bus;
mod clock;
mod control;
mod core;
mod guarded;
mod motion;
mod native;
mod neighbours;
mod node;
mod notice;
mod parameter_file;
mod quantity;
mod receiver;
mod record;
mod requests;
mod servos;
mod token;
mod web;

use std::io::{self, ErrorKind};
use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};

use host_sim::can::link::{Link, open_split};
use host_sim::servo_bus::client::{Client, ServoError, is_servo_bus};

use crate::core::{Core, PageState, State};
use crate::neighbours::{Neighbour, Register};
use serde_json::{Value, json};
use servos::Servos;
use token::Token;
use web::{Application, Download, PageId, Server};

pub use native::NativeBus;
pub use notice::Notice;

/// What to serve.
#[derive(Debug, Clone)]
pub struct Options {
    /// Address of the page; if the port is taken, another one of this computer is used.
    pub listen: SocketAddr,
    /// The bus, as `host_sim::can::link::open` takes it, or one of servos, as
    /// `host_sim::servo_bus::client::Client::open` does.
    pub bus: String,
    /// Its name on the page.
    pub bus_name: String,
    /// Its bit rate, kbit/s.
    pub kbit_s: u16,
    /// Those of [`NativeBus::encoder_switches`]; empty for a bus of others.
    pub encoder_switches: Vec<Arc<AtomicBool>>,
}

/// Why Studio does not start.
#[derive(Debug, thiserror::Error)]
pub enum StudioError {
    /// The bus cannot be opened.
    #[error("cannot open the bus `{bus}`: {source}")]
    Bus {
        /// Its name.
        bus: String,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The bus of servos cannot be opened.
    #[error(transparent)]
    Servos(#[from] ServoError),
    /// The page cannot be served.
    #[error("cannot serve at {address}: {source}")]
    Serve {
        /// The address.
        address: SocketAddr,
        /// The error of the operating system.
        source: io::Error,
    },
    /// A simulated actuator cannot be made.
    #[error(transparent)]
    Parameter(#[from] model_core::parameter::ParameterError),
}

/// What the thread of the bus begins with.
enum Line {
    Can(Box<dyn Link + Send>),
    Servos(Box<Client>, Receiver<servos::Job>),
}

/// The server of the page, and the bus.
pub struct Studio {
    core: Arc<Core>,
    server: Server,
    line: Line,
    token: Token,
    options: Options,
}

impl Studio {
    /// Opens the bus and the port of the page; `log` gets each entry of the log.
    ///
    /// # Errors
    /// [`StudioError`].
    pub fn open(
        options: Options,
        log: impl Fn(&str) + Send + Sync + 'static,
    ) -> Result<Self, StudioError> {
        let serve = |source| StudioError::Serve {
            address: options.listen,
            source,
        };
        let token = Token::random().map_err(|error| serve(io::Error::other(error)))?;
        let server = listen(options.listen).and_then(|l| Server::new(l, token.clone()));
        let server = server.map_err(serve)?;
        let mut core = Core::new(
            server.pages(),
            options.kbit_s,
            options.encoder_switches.clone(),
            Box::new(log),
        );
        let line = if is_servo_bus(&options.bus) {
            let client = Client::open(&options.bus)?;
            let (way, jobs) = Servos::new();
            core.servos = Some(way);
            Line::Servos(Box::new(client), jobs)
        } else {
            let bus = open_split(&options.bus, options.kbit_s);
            let bus = bus.map_err(|source| StudioError::Bus {
                bus: options.bus.clone(),
                source,
            })?;
            core.hub.connect(Some(bus.transmitter));
            Line::Can(bus.receiver)
        };
        Ok(Self {
            core: Arc::new(core),
            server,
            line,
            token,
            options,
        })
    }

    /// Where the page is, without the token.
    pub fn address(&self) -> SocketAddr {
        self.server.address()
    }

    /// The address that a browser opens.
    pub fn url(&self) -> String {
        format!("http://{}/?token={}", self.address(), self.token.text())
    }

    /// Serves until `stop` is set, then stops the drives and leaves the actuators as they were.
    ///
    /// # Errors
    /// If the system cannot wait for events.
    pub fn run(self, stop: &AtomicBool, notify: &mut dyn FnMut(&Notice)) -> io::Result<()> {
        let own = Neighbour::new(&self.options.bus_name, self.url(), self.address());
        let Self {
            core,
            mut server,
            line,
            options,
            token: _,
        } = self;
        let has_ended = AtomicBool::new(false);
        if core.servos.is_none() {
            // Without room for a task there is a scan under way.
            let _ = core.spawn(|core, task| attach::scan(core, &task));
        }
        std::thread::scope(|scope| {
            let (core, ended) = (&core, &has_ended);
            let bus = &options.bus;
            scope.spawn(move || match line {
                Line::Can(link) => receiver::run(core, bus, link, ended),
                Line::Servos(client, jobs) => servos::run(core, bus, *client, &jobs, ended),
            });
            scope.spawn(move || clock::run(core, ended));
            scope.spawn(move || watch_neighbours(core, own, ended));
            let bridge = Bridge {
                core,
                bus: &options.bus_name,
            };
            let served = server.run(&bridge, stop, notify);
            motion::leave(core);
            has_ended.store(true, Relaxed);
            served
        })
    }
}

/// Reports the other Studios on this computer to the pages, unless others can reach this one: its
/// pages would learn addresses with their tokens.
fn watch_neighbours(core: &Core, own: Neighbour, ended: &AtomicBool) {
    const PERIOD: Duration = Duration::from_secs(2);
    const PATIENCE: Duration = Duration::from_millis(50);
    let folder = own.is_private().then(neighbours::folder).flatten();
    let Some(register) = folder.and_then(|folder| Register::join(folder, &own).ok()) else {
        return;
    };
    while !ended.load(Relaxed) {
        let others = register.others();
        let has_changed = core.with(|state| {
            let has_changed = state.neighbours != others;
            state.neighbours = others;
            has_changed.then(|| neighbours_event(state))
        });
        if let Some(event) = has_changed {
            core.pages.tell_all(&event);
        }
        let end = Instant::now() + PERIOD;
        while Instant::now() < end && !ended.load(Relaxed) {
            std::thread::sleep(PATIENCE);
        }
    }
}

fn neighbours_event(state: &State) -> Value {
    json!({ "event": "neighbours", "others": state.neighbours })
}

/// A listener at this address, or at another port if this one is taken.
fn listen(address: SocketAddr) -> io::Result<TcpListener> {
    match TcpListener::bind(address) {
        Err(error) if error.kind() == ErrorKind::AddrInUse => {
            TcpListener::bind(SocketAddr::new(address.ip(), 0))
        }
        bound => bound,
    }
}

/// Events of the server for the state.
struct Bridge<'a> {
    core: &'a Arc<Core>,
    bus: &'a str,
}

impl Application for Bridge<'_> {
    fn joined(&self, page: PageId) {
        let now_s = self.core.now_s();
        let (hello, devices, neighbours, control, samples) = self.core.with(|state| {
            let alive = Instant::now();
            state.pages.insert(page, PageState { alive });
            state.control.joined(page);
            (
                requests::hello(page, self.core, state, self.bus),
                clock::devices(state),
                neighbours_event(state),
                state.control.event(),
                clock::past(state, quantity::of(self.core).len(), now_s),
            )
        });
        for event in [&hello, &devices, &neighbours] {
            self.core.pages.tell(page, event);
        }
        self.core.pages.past(page, samples);
        self.core.pages.tell_all(&control);
    }

    fn left(&self, page: PageId) {
        let control = self.core.with(|state| {
            state.pages.remove(&page);
            state.control.left(page);
            let nodes = state.nodes.values_mut();
            nodes.for_each(|node| node.record.release(page));
            state.control.event()
        });
        self.core.pages.tell_all(&control);
    }

    fn message(&self, page: PageId, text: &str) {
        requests::handle(self.core, page, text);
    }

    fn download(&self, name: &str) -> Option<Download> {
        self.core.take_file(name)
    }
}
