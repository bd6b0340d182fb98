//! A server with an slcan adapter on the bus for each client.
//!
//! Two threads, so that no client can hold up the actuators: `nodes` runs the control periods and
//! carries frames; this one accepts clients, reads, and writes. Between them are queues with
//! bounds. A client that sends too much has to wait, in turns with the others; one that does not
//! read loses lines, which its adapter flags (`F`); the server reports both.

mod client;
mod nodes;
mod notice;

use std::io::{self, ErrorKind};
use std::net::TcpListener;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::mpsc::{self, Receiver, Sender, TryRecvError};
use std::thread::{self, Thread};
use std::time::{Duration, Instant};

use mio::{Events, Interest, Poll, Token, Waker};

use super::bus::Bus;
use client::{Client, INBOX_FRAMES, is_due};
use nodes::{Inbox, Losses, Nodes, Outlet, Traffic};

pub use client::Stream;
#[cfg(unix)]
pub use client::Terminal;
pub use notice::Notice;

/// Most clients at a time, which bounds the memory.
pub const CLIENTS_MAX: usize = 64;

/// Frames between the threads: those of several control periods.
const TRAFFIC_FRAMES: usize = 8192;

/// Time after which room in an inbox is looked for again.
const BUS_PERIOD: Duration = Duration::from_millis(1);

/// Time after which a refused connection is tried again.
const ACCEPT_PERIOD: Duration = Duration::from_millis(100);

const LISTENER: Token = Token(usize::MAX);
const NODES: Token = Token(usize::MAX - 1);

/// A client that is there from the start.
struct Permanent {
    name: String,
    stream: Box<dyn Stream>,
}

/// A bus and its clients.
pub struct Server<'a> {
    bus: Bus<'a>,
    permanent: Vec<Permanent>,
}

impl<'a> Server<'a> {
    /// A server without clients.
    pub fn new(bus: Bus<'a>) -> Self {
        Self {
            bus,
            permanent: Vec::new(),
        }
    }

    /// Adds a client with a non-blocking stream, which is not removed when its reader closes it.
    pub fn add(&mut self, name: &str, stream: impl Stream + 'static) {
        self.permanent.push(Permanent {
            name: name.to_owned(),
            stream: Box::new(stream),
        });
    }

    /// Runs the bus in real time until `stop` is set; `notify` receives its notices.
    ///
    /// # Errors
    /// If the system cannot wait for events.
    pub fn run(
        &mut self,
        listener: Option<TcpListener>,
        stop: &AtomicBool,
        notify: &mut dyn FnMut(&Notice),
    ) -> io::Result<()> {
        let poll = Poll::new()?;
        let waker = Waker::new(poll.registry(), NODES)?;
        let listener = listener
            .map(|listener| listen(&poll, listener))
            .transpose()?;
        let (to_clients, traffic) = mpsc::sync_channel(TRAFFIC_FRAMES);
        let (join, joining) = mpsc::channel();
        let losses = Losses::default();
        let nodes = Nodes {
            bus: &mut self.bus,
            joining,
            inboxes: Vec::new(),
            turn: 0,
            outlet: Outlet {
                traffic: to_clients,
                losses: &losses,
                waker: &waker,
                is_waiting: false,
            },
            start: Instant::now(),
        };
        let permanent = std::mem::take(&mut self.permanent);
        thread::scope(|scope| {
            let waker = &waker;
            let thread = scope.spawn(move || {
                let _wake = WakeOnDrop(waker);
                nodes.run(stop);
            });
            let mut clients = Clients {
                poll,
                listener,
                is_accepting: true,
                is_refusing: false,
                clients: Vec::new(),
                next_number: 0,
                join,
                traffic,
                losses: &losses,
                nodes: thread.thread().clone(),
                late: None,
                notify,
            };
            for Permanent { name, stream } in permanent {
                clients.add(name, stream, true)?;
            }
            clients.run()
        })
    }
}

fn listen(poll: &Poll, listener: TcpListener) -> io::Result<mio::net::TcpListener> {
    listener.set_nonblocking(true)?;
    let mut listener = mio::net::TcpListener::from_std(listener);
    poll.registry()
        .register(&mut listener, LISTENER, Interest::READABLE)?;
    Ok(listener)
}

/// Wakes the thread of the clients when that of the actuators has ended.
struct WakeOnDrop<'s>(&'s Waker);

impl Drop for WakeOnDrop<'_> {
    fn drop(&mut self) {
        // It fails if that thread has ended already.
        let _ = self.0.wake();
    }
}

/// The thread of the clients.
struct Clients<'s> {
    poll: Poll,
    listener: Option<mio::net::TcpListener>,
    /// Whether there may be a connection to accept.
    is_accepting: bool,
    /// Whether the last connection could not be accepted.
    is_refusing: bool,
    clients: Vec<Client>,
    next_number: u64,
    join: Sender<Inbox>,
    traffic: Receiver<Traffic>,
    losses: &'s Losses,
    nodes: Thread,
    /// The last notice of skipped control periods.
    late: Option<Instant>,
    notify: &'s mut dyn FnMut(&Notice),
}

impl Clients<'_> {
    fn run(&mut self) -> io::Result<()> {
        let mut events = Events::with_capacity(2 * CLIENTS_MAX);
        loop {
            if let Err(error) = self.poll.poll(&mut events, self.timeout())
                && error.kind() != ErrorKind::Interrupted
            {
                return Err(error);
            }
            for event in &events {
                let is_readable = event.is_readable() || event.is_read_closed() || event.is_error();
                let is_writable = event.is_writable() || event.is_write_closed();
                if event.token() == LISTENER {
                    self.is_accepting = true;
                } else if let Some(client) = self.of_token(event.token()) {
                    client.has_event(is_readable, is_writable);
                }
            }
            if self.is_accepting {
                self.accept();
            }
            self.read();
            if !self.deliver() {
                return Ok(());
            }
            for client in &mut self.clients {
                client.write(self.notify);
            }
            self.clients.retain(|client| !client.is_gone());
        }
    }

    /// Time to wait for events, at most.
    fn timeout(&self) -> Option<Duration> {
        if self.clients.iter().any(Client::wants_turn) {
            return Some(Duration::ZERO);
        }
        if self.clients.iter().any(Client::waits_for_bus) {
            return Some(BUS_PERIOD);
        }
        self.is_accepting.then_some(ACCEPT_PERIOD)
    }

    fn of_token(&mut self, token: Token) -> Option<&mut Client> {
        let number = token.0 as u64;
        let mut clients = self.clients.iter_mut();
        clients.find(|client| client.number() == number)
    }

    /// Accepts all clients that wait, as far as the system has connections for them.
    fn accept(&mut self) {
        while let Some(listener) = &self.listener {
            let notice = match listener.accept() {
                Ok(_) if self.clients.len() >= CLIENTS_MAX => Notice::Full,
                Ok((stream, address)) => {
                    let added = stream
                        .set_nodelay(true)
                        .and_then(|()| self.add(address.to_string(), Box::new(stream), false));
                    match added {
                        Ok(()) => {
                            self.is_refusing = false;
                            continue;
                        }
                        Err(error) => Notice::NotAccepted(error),
                    }
                }
                Err(error) if error.kind() == ErrorKind::WouldBlock => break,
                Err(error) if is_of_one_client(&error) => continue,
                Err(error) => {
                    self.refuse(&Notice::NotAccepted(error));
                    // Tried again later.
                    return;
                }
            };
            self.refuse(&notice);
        }
        self.is_accepting = false;
    }

    /// Reports the first of several refusals.
    fn refuse(&mut self, notice: &Notice) {
        if !std::mem::replace(&mut self.is_refusing, true) {
            (self.notify)(notice);
        }
    }

    fn add(&mut self, name: String, stream: Box<dyn Stream>, is_permanent: bool) -> io::Result<()> {
        let number = self.next_number;
        self.next_number += 1;
        let (inbox, frames) = mpsc::sync_channel(INBOX_FRAMES);
        let mut client = Client::new(number, name, stream, is_permanent, inbox);
        let both = Interest::READABLE | Interest::WRITABLE;
        let token = Token(number as usize);
        self.poll
            .registry()
            .register(client.stream(), token, both)?;
        // It fails if the actuators' thread has ended; then this one ends too.
        let _ = self.join.send(Inbox::new(number, frames));
        self.clients.push(client);
        Ok(())
    }

    /// A turn of each client.
    fn read(&mut self) {
        let mut has_sent = false;
        for client in &mut self.clients {
            has_sent |= client.take_turn(self.notify);
        }
        if has_sent {
            self.nodes.unpark();
        }
    }

    /// Delivers what was on the bus; returns whether the actuators' thread still runs.
    fn deliver(&mut self) -> bool {
        for _ in 0..TRAFFIC_FRAMES {
            match self.traffic.try_recv() {
                Ok(traffic) => {
                    for client in &mut self.clients {
                        client.deliver(&traffic);
                    }
                }
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) => return false,
            }
        }
        let lost = self.losses.frames.swap(0, Relaxed);
        if lost > 0 {
            self.clients
                .iter_mut()
                .for_each(|client| client.has_lost(lost));
        }
        let is_late = self.losses.periods.load(Relaxed) > 0;
        if is_late && is_due(&mut self.late) {
            let periods = self.losses.periods.swap(0, Relaxed);
            (self.notify)(&Notice::Late { periods });
        }
        true
    }
}

/// Whether the client that would have been accepted has gone already.
fn is_of_one_client(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::Interrupted | ErrorKind::ConnectionAborted | ErrorKind::ConnectionReset
    )
}
