//! A bus in real time, with its clients.
//!
//! One thread: a request is answered when the line would have carried it. As on a line, all clients
//! hear nothing of each other but what they do to the servos.

use std::io::{self, ErrorKind};
use std::net::TcpListener;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::mpsc::Receiver;
use std::thread;
use std::time::{Duration, Instant};

use mio::{Events, Interest, Poll, Token};

use super::bus::{Bus, Sent};
use super::fault::Fault;
use crate::can::server::Stream;

/// Time between two looks at the clock while nothing arrives.
const IDLE: Duration = Duration::from_millis(10);

/// Pause of a client after which a part of a packet is discarded.
const GAP: Duration = Duration::from_millis(50);

/// Bits of a byte on the line: with start and stop bit.
const BYTE_BITS: u64 = 10;

const LISTENER: Token = Token(usize::MAX);

const INTEREST: Interest = Interest::READABLE.add(Interest::WRITABLE);

/// Most clients at a time.
const CLIENTS_MAX: usize = 16;

/// A client and its stream.
struct Client {
    stream: Box<dyn Stream>,
    /// A terminal remains when its reader closes it.
    is_permanent: bool,
    unsent: Vec<u8>,
    is_gone: bool,
}

/// A bus and its clients.
pub struct Server {
    bus: Bus,
    bit_s: u64,
    start: Instant,
    heard: Instant,
    clients: Vec<Option<Client>>,
    poll: Poll,
}

impl Server {
    /// A server of a line with this bit rate.
    ///
    /// # Errors
    /// If the system cannot wait for events.
    pub fn new(bus: Bus, bit_s: u64) -> io::Result<Self> {
        Ok(Self {
            bus,
            bit_s,
            start: Instant::now(),
            heard: Instant::now(),
            clients: Vec::new(),
            poll: Poll::new()?,
        })
    }

    /// Adds a client with a non-blocking stream, which is not removed when its reader closes it.
    ///
    /// # Errors
    /// If the system cannot wait for its events.
    pub fn add(&mut self, stream: impl Stream + 'static) -> io::Result<()> {
        self.join(Box::new(stream), true)
    }

    fn join(&mut self, mut stream: Box<dyn Stream>, is_permanent: bool) -> io::Result<()> {
        let free = self.clients.iter().position(Option::is_none);
        let place = free.unwrap_or(self.clients.len());
        self.poll
            .registry()
            .register(&mut stream, Token(place), INTEREST)?;
        let client = Some(Client {
            stream,
            is_permanent,
            unsent: Vec::new(),
            is_gone: false,
        });
        match self.clients.get_mut(place) {
            Some(entry) => *entry = client,
            None => self.clients.push(client),
        }
        Ok(())
    }

    /// Runs the bus in real time, with the faults that arrive, until `stop` is set.
    ///
    /// # Errors
    /// If the system cannot wait for events.
    pub fn run(
        mut self,
        listener: Option<TcpListener>,
        faults: &Receiver<Fault>,
        stop: &AtomicBool,
    ) -> io::Result<()> {
        let mut listener = listener.map(mio::net::TcpListener::from_std);
        if let Some(listener) = &mut listener {
            self.poll
                .registry()
                .register(listener, LISTENER, Interest::READABLE)?;
        }
        let mut events = Events::with_capacity(2 * CLIENTS_MAX);
        while !stop.load(Relaxed) {
            match self.poll.poll(&mut events, Some(IDLE)) {
                Err(error) if error.kind() != ErrorKind::Interrupted => return Err(error),
                _ => {}
            }
            faults.try_iter().for_each(|fault| self.bus.apply(fault));
            self.bus.advance_to(self.start.elapsed().as_micros() as u64);
            for event in &events {
                match (event.token(), &listener) {
                    (LISTENER, Some(listener)) => self.accept(listener),
                    (Token(place), _) => self.serve(place),
                }
            }
        }
        Ok(())
    }

    fn accept(&mut self, listener: &mio::net::TcpListener) {
        while let Ok((stream, _)) = listener.accept() {
            let count = self.clients.iter().flatten().count();
            // Without a delay of small packets; one that is refused is closed.
            if count < CLIENTS_MAX && stream.set_nodelay(true).is_ok() {
                let _ = self.join(Box::new(stream), false);
            }
        }
    }

    /// Reads at most the bytes of a packet from a client, and answers.
    fn serve(&mut self, place: usize) {
        let Some(mut client) = self.clients.get_mut(place).and_then(Option::take) else {
            return;
        };
        let mut bytes = [0; servo_bus::CAPACITY];
        if let Some(length) = client.read(&mut bytes) {
            if self.heard.elapsed() > GAP {
                self.bus.discard();
            }
            let mut sent = Sent::default();
            self.bus.receive(&bytes[..length], &mut sent);
            self.wait(length, &sent);
            client.unsent.append(&mut sent.bytes);
            self.heard = Instant::now();
            // The rest is another event: time passes for the servos, and the other clients, before
            // it.
            let rest = self
                .poll
                .registry()
                .reregister(&mut client.stream, Token(place), INTEREST);
            client.is_gone |= rest.is_err();
        }
        client.write();
        if client.is_gone && !client.is_permanent {
            let _ = self.poll.registry().deregister(&mut client.stream);
        } else if let Some(entry) = self.clients.get_mut(place) {
            *entry = Some(client);
        }
    }

    /// Waits for as long as the line carries a request and its answer. Time passes for the servos
    /// at the next turn.
    fn wait(&self, length: usize, sent: &Sent) {
        let bits = (length + sent.bytes.len()) as u64 * BYTE_BITS;
        thread::sleep(Duration::from_micros(
            sent.delay_us + bits * 1_000_000 / self.bit_s,
        ));
    }
}

impl Client {
    /// The bytes that have arrived; `None` if there are none.
    fn read(&mut self, bytes: &mut [u8]) -> Option<usize> {
        loop {
            match self.stream.read(bytes) {
                Ok(0) => self.is_gone = true,
                Ok(length) => return Some(length),
                Err(error) if error.kind() == ErrorKind::Interrupted => continue,
                Err(error) if error.kind() == ErrorKind::WouldBlock => {}
                Err(_) => self.is_gone = true,
            }
            return None;
        }
    }

    /// Sends what it takes; the rest is lost, as on a line whose receiver does not read.
    fn write(&mut self) {
        while !self.unsent.is_empty() {
            match self.stream.write(&self.unsent) {
                Ok(length) if length > 0 => drop(self.unsent.drain(..length)),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                _ => break,
            }
        }
        self.unsent.clear();
    }
}
