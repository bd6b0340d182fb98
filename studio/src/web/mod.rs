//! The server of the page: files over HTTP, and a WebSocket for each page.
//!
//! One thread waits for all connections. Everything that others can fill has a bound: connections,
//! heads, messages, and the bytes that wait for a page that does not read. Samples that do not fit
//! are dropped, and their number is reported to the page; a page that does not even read answers is
//! closed.

mod assets;
mod connection;
mod guard;
mod pages;
mod response;

use std::collections::BTreeMap;
use std::io::{self, ErrorKind};
use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::mpsc::{self, Receiver};
use std::time::{Duration, Instant};

use mio::{Events, Interest, Poll, Token as EventToken, Waker};
use serde_json::json;
use tungstenite::protocol::frame::coding::CloseCode;

use crate::notice::Notice;
use crate::token::Token;
use connection::{Connection, Reason, Turn};
use guard::Guard;
use pages::{Losses, MESSAGES, Message};

pub use connection::Download;
pub use pages::{PageId, Pages};

/// Most connections at a time. Another one replaces the oldest that is not a page and has had its
/// [`GRACE`].
pub const CONNECTIONS_MAX: usize = 64;

/// Time that a connection has for its request, however many others wait in the queue of the system.
const GRACE: Duration = Duration::from_millis(100);

/// Time between two notices about refused connections.
const NOTICE_PERIOD: Duration = Duration::from_secs(5);

const LISTENER: EventToken = EventToken(0);
const WAKER: EventToken = EventToken(1);

/// What the pages talk to.
pub trait Application {
    /// A page is there.
    fn joined(&self, page: PageId);

    /// A page has closed.
    fn left(&self, page: PageId);

    /// A message of a page. It must not wait.
    fn message(&self, page: PageId, text: &str);

    /// A file for the user.
    fn download(&self, name: &str) -> Option<Download>;
}

/// The server.
pub struct Server {
    poll: Poll,
    listener: mio::net::TcpListener,
    address: SocketAddr,
    guard: Guard,
    connections: BTreeMap<PageId, Connection>,
    next: PageId,
    /// Whether connections may wait in the queue of the system.
    has_waiting: bool,
    messages: Receiver<Message>,
    losses: Arc<Losses>,
    pages: Pages,
    refused: u64,
    noticed: Option<Instant>,
}

impl Server {
    /// A server behind this listener, for clients with the token.
    ///
    /// # Errors
    /// Those of the operating system.
    pub fn new(listener: TcpListener, token: Token) -> io::Result<Self> {
        listener.set_nonblocking(true)?;
        let address = listener.local_addr()?;
        let mut listener = mio::net::TcpListener::from_std(listener);
        let poll = Poll::new()?;
        poll.registry()
            .register(&mut listener, LISTENER, Interest::READABLE)?;
        let waker = Arc::new(Waker::new(poll.registry(), WAKER)?);
        let (sender, messages) = mpsc::sync_channel(MESSAGES);
        let losses = Arc::new(Losses::default());
        Ok(Self {
            poll,
            listener,
            address,
            guard: Guard::new(address, token),
            connections: BTreeMap::new(),
            next: WAKER.0 as PageId + 1,
            has_waiting: false,
            messages,
            pages: Pages::new(sender, waker, Arc::clone(&losses)),
            losses,
            refused: 0,
            noticed: None,
        })
    }

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// The way to its pages.
    pub fn pages(&self) -> Pages {
        self.pages.clone()
    }

    /// Serves until `stop` is set.
    ///
    /// # Errors
    /// If the system cannot wait for events.
    pub fn run(
        &mut self,
        application: &dyn Application,
        stop: &AtomicBool,
        notify: &mut dyn FnMut(&Notice),
    ) -> io::Result<()> {
        /// `stop` may be set by a signal, which wakes no thread.
        const LONGEST_WAIT: Duration = Duration::from_millis(100);
        /// Connections that wait cause no event when the grace of another one is over.
        const RETRY: Duration = Duration::from_millis(10);
        let mut events = Events::with_capacity(2 * CONNECTIONS_MAX);
        while !stop.load(Relaxed) {
            let has_more = self.connections.values().any(|one| one.is_readable);
            let wait = match (has_more, self.has_waiting) {
                (true, _) => Duration::ZERO,
                (false, true) => RETRY,
                (false, false) => LONGEST_WAIT,
            };
            if let Err(error) = self.poll.poll(&mut events, Some(wait))
                && error.kind() != ErrorKind::Interrupted
            {
                return Err(error);
            }
            for event in &events {
                if event.token() == LISTENER {
                    self.has_waiting = true;
                } else if let Some(one) = self.connections.get_mut(&(event.token().0 as PageId)) {
                    one.is_readable = true;
                }
            }
            self.accept();
            self.receive(application, notify);
            self.deliver(application, notify);
            self.expire(notify);
        }
        for one in self.connections.values_mut() {
            one.close(CloseCode::Away, "the server ends");
        }
        Ok(())
    }

    /// Accepts connections; those that would replace one that still has its grace wait.
    fn accept(&mut self) {
        while self.has_waiting {
            let is_full = self.connections.len() >= CONNECTIONS_MAX;
            let oldest = self.connections.iter().find(|(_, one)| !one.is_page());
            if is_full && oldest.is_some_and(|(_, one)| one.age() < GRACE) {
                return;
            }
            let oldest = oldest.map(|(id, _)| *id);
            let (mut stream, from) = match self.listener.accept() {
                Ok(accepted) => accepted,
                // Another error is of one client, or passes.
                Err(error) => {
                    self.has_waiting = error.kind() != ErrorKind::WouldBlock;
                    return;
                }
            };
            if is_full {
                self.refused += 1;
                let Some(oldest) = oldest else {
                    continue;
                };
                self.connections.remove(&oldest);
            }
            let id = self.next;
            self.next += 1;
            let both = Interest::READABLE | Interest::WRITABLE;
            let token = EventToken(id as usize);
            let is_ready = stream
                .set_nodelay(true)
                .and_then(|()| self.poll.registry().register(&mut stream, token, both));
            if is_ready.is_ok() {
                let connection = Connection::new(stream, from.to_string());
                self.connections.insert(id, connection);
            }
        }
    }

    /// Reads from each readable connection.
    fn receive(&mut self, application: &dyn Application, notify: &mut dyn FnMut(&Notice)) {
        let mut ended = Vec::new();
        for (id, one) in &mut self.connections {
            if !one.is_readable {
                continue;
            }
            one.flush();
            let download = |name: &str| application.download(name);
            let mut receive = |text: &str| application.message(*id, text);
            match one.take_turn(&self.guard, &download, &mut receive) {
                Turn::Goes => {}
                Turn::Joined => application.joined(*id),
                Turn::Ended(reason) => ended.push((*id, reason)),
            }
        }
        for (id, reason) in ended {
            self.end(id, reason, application, notify);
        }
    }

    fn end(
        &mut self,
        id: PageId,
        reason: Option<Reason>,
        application: &dyn Application,
        notify: &mut dyn FnMut(&Notice),
    ) {
        let Some(one) = self.connections.remove(&id) else {
            return;
        };
        let from = one.from.clone();
        match reason {
            Some(Reason::Refused(why)) => notify(&Notice::Refused { from, why }),
            Some(Reason::Closed(why)) => notify(&Notice::Closed { from, why }),
            None => {}
        }
        if one.is_page() {
            application.left(id);
        }
    }

    /// Passes messages on.
    fn deliver(&mut self, application: &dyn Application, notify: &mut dyn FnMut(&Notice)) {
        let mut slow = Vec::new();
        for _ in 0..MESSAGES {
            let Ok(message) = self.messages.try_recv() else {
                break;
            };
            match message {
                Message::One(id, text) => {
                    if let Some(one) = self.connections.get_mut(&id)
                        && !one.send_text(&text)
                    {
                        slow.push(id);
                    }
                }
                Message::All(text) => {
                    for (id, one) in self.connections.iter_mut().filter(|(_, one)| one.is_page()) {
                        if !one.send_text(&text) {
                            slow.push(*id);
                        }
                    }
                }
                Message::Past(id, bytes) => {
                    if let Some(one) = self.connections.get_mut(&id) {
                        one.send_samples(0, &bytes);
                    }
                }
                Message::Samples(number, bytes) => {
                    for one in self.connections.values_mut().filter(|one| one.is_page()) {
                        one.send_samples(number, &bytes);
                    }
                }
            }
        }
        if self.losses.has_lost_text.swap(false, Relaxed) {
            slow.extend(
                self.connections
                    .iter()
                    .filter(|(_, one)| one.is_page())
                    .map(|(id, _)| *id),
            );
        }
        for id in slow {
            let why = "it does not read".to_owned();
            self.end(id, Some(Reason::Closed(why)), application, notify);
        }
        self.tell_losses();
    }

    /// Reports to pages that read again how many samples they lack.
    fn tell_losses(&mut self) {
        let lost = self.losses.samples.swap(0, Relaxed);
        for one in self.connections.values_mut().filter(|one| one.is_page()) {
            one.lost_samples += lost;
            if one.lost_samples > 0 && one.flush() {
                let samples = std::mem::take(&mut one.lost_samples);
                one.send_text(&json!({ "event": "dropped", "samples": samples }).to_string());
            }
        }
    }

    /// Ends requests that take too long, and reports refused connections.
    fn expire(&mut self, notify: &mut dyn FnMut(&Notice)) {
        let now = Instant::now();
        self.connections
            .retain(|_, one| one.deadline().is_none_or(|deadline| now < deadline));
        let is_due = self.noticed.is_none_or(|last| now - last > NOTICE_PERIOD);
        if self.refused > 0 && is_due {
            self.noticed = Some(now);
            let refused = std::mem::take(&mut self.refused);
            notify(&Notice::Full {
                connections: CONNECTIONS_MAX,
                refused,
            });
        }
    }
}

#[cfg(test)]
mod tests;
