//! Serves a bus as slcan: every client has an adapter of its own on it.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use canopen::CanFrame;
use canopen::slcan::{self, Adapter};

use super::bus::{Bus, Port};

/// Bytes that may wait for a client; what comes then is lost for it, as at an adapter's serial line.
const MOST_WAITING: usize = 1 << 18;

/// Between two looks at sockets and clock.
const NAP: Duration = Duration::from_micros(500);

/// What an adapter needs of the bus: a list of what the client sends.
#[derive(Default)]
struct Outbox(Vec<CanFrame>);

impl slcan::Bus for Outbox {
    /// Every bit rate is right on a bus without one.
    fn open(&mut self, _: Option<u16>, _: bool) -> bool {
        true
    }

    fn close(&mut self) {}

    fn send(&mut self, frame: &CanFrame) -> bool {
        self.0.push(*frame);
        true
    }

    fn flags(&mut self) -> u8 {
        0
    }
}

/// A line to a client that is there.
pub trait Line: Read + Write {}

impl<T: Read + Write> Line for T {}

/// One client.
struct Client {
    number: u64,
    line: Box<dyn Line>,
    adapter: Adapter,
    waiting: Vec<u8>,
    /// A terminal stays when its reader goes.
    stays: bool,
}

impl Client {
    fn new(number: u64, line: Box<dyn Line>, stays: bool) -> Self {
        Self {
            number,
            line,
            adapter: Adapter::new(*b"0001"),
            waiting: Vec::new(),
            stays,
        }
    }

    /// Whether the client is still there.
    fn read(&mut self, bus: &mut Bus<'_>) -> bool {
        let mut buffer = [0; 4096];
        loop {
            let length = match self.line.read(&mut buffer) {
                Ok(0) => return self.stays,
                Ok(length) => length,
                Err(error) if is_nothing(&error) => return true,
                Err(_) => return self.stays,
            };
            let mut outbox = Outbox::default();
            for byte in &buffer[..length] {
                if let Some(answer) = self.adapter.receive(*byte, &mut outbox) {
                    self.waiting.extend_from_slice(answer.as_bytes());
                }
            }
            for frame in outbox.0 {
                bus.send(self.number, frame);
            }
        }
    }

    fn hear(&mut self, from: Port, frame: &CanFrame, now_us: u64) {
        if from == Port::Client(self.number) {
            return;
        }
        let Some(text) = self.adapter.frame(frame, now_us) else {
            return;
        };
        if self.waiting.len() < MOST_WAITING {
            self.waiting.extend_from_slice(text.as_bytes());
        } else {
            self.adapter.line_lost();
        }
    }

    /// Whether the client is still there.
    fn write(&mut self) -> bool {
        while !self.waiting.is_empty() {
            match self.line.write(&self.waiting) {
                Ok(0) => return self.stays,
                Ok(length) => drop(self.waiting.drain(..length)),
                Err(error) if is_nothing(&error) => return true,
                Err(_) => return self.stays,
            }
        }
        true
    }
}

fn is_nothing(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted
    )
}

/// A bus and its clients.
pub struct Server<'a> {
    bus: Bus<'a>,
    clients: Vec<Client>,
    next: u64,
    begun: Instant,
}

impl<'a> Server<'a> {
    /// Without clients.
    pub fn new(bus: Bus<'a>) -> Self {
        Self {
            bus,
            clients: Vec::new(),
            next: 0,
            begun: Instant::now(),
        }
    }

    /// Takes a client whose line never blocks; one that `stays` is there for whoever comes next.
    pub fn add(&mut self, line: impl Line + 'static, stays: bool) {
        let client = Client::new(self.next, Box::new(line), stays);
        self.next += 1;
        self.clients.push(client);
    }

    /// Serves in real time until `stop` is set.
    ///
    /// # Errors
    /// What the listening socket says.
    pub fn run(&mut self, listener: Option<&TcpListener>, stop: &AtomicBool) -> io::Result<()> {
        while !stop.load(Ordering::Relaxed) {
            while let Some(stream) = listener.map_or(Ok(None), accept)? {
                self.add(stream, false);
            }
            self.turn();
            std::thread::sleep(NAP);
        }
        Ok(())
    }

    fn turn(&mut self) {
        let Self {
            bus,
            clients,
            begun,
            ..
        } = self;
        let now_us = begun.elapsed().as_micros() as u64;
        clients.retain_mut(|client| client.read(bus));
        bus.run(now_us, |from, frame| {
            for client in &mut *clients {
                client.hear(from, frame, now_us);
            }
        });
        clients.retain_mut(Client::write);
    }
}

/// A client that wants in.
fn accept(listener: &TcpListener) -> io::Result<Option<TcpStream>> {
    match listener.accept() {
        Ok((stream, _)) => {
            stream.set_nonblocking(true)?;
            stream.set_nodelay(true)?;
            Ok(Some(stream))
        }
        Err(error) if is_nothing(&error) => Ok(None),
        Err(error) => Err(error),
    }
}
