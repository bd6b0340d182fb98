//! A server that gives each client an slcan adapter of its own on the bus.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use canopen::CanFrame;
use canopen::slcan::{self, Adapter};

use super::bus::{Bus, Port};

/// Bytes in the send buffer of a client; further frames are lost, as at an adapter's serial line.
const SEND_BUFFER: usize = 1 << 18;

/// Time between two polls of sockets and clock.
const POLL_PERIOD: Duration = Duration::from_micros(500);

/// The bus of an adapter: a list of the frames that the client sends.
#[derive(Default)]
struct Outbox(Vec<CanFrame>);

impl slcan::Bus for Outbox {
    /// The virtual bus has no bit rate: any is accepted.
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

/// A non-blocking stream to a client.
pub trait Stream: Read + Write {}

impl<T: Read + Write> Stream for T {}

/// One client.
struct Client {
    number: u64,
    stream: Box<dyn Stream>,
    adapter: Adapter,
    unsent: Vec<u8>,
    /// A terminal is_permanent open when its reader closes it.
    is_permanent: bool,
}

impl Client {
    fn new(number: u64, stream: Box<dyn Stream>, is_permanent: bool) -> Self {
        Self {
            number,
            stream,
            adapter: Adapter::new(*b"0001"),
            unsent: Vec::new(),
            is_permanent,
        }
    }

    /// Reads and handles commands; returns whether the client is still connected.
    fn read(&mut self, bus: &mut Bus<'_>) -> bool {
        let mut buffer = [0; 4096];
        loop {
            let length = match self.stream.read(&mut buffer) {
                Ok(0) => return self.is_permanent,
                Ok(length) => length,
                Err(error) if is_temporary(&error) => return true,
                Err(_) => return self.is_permanent,
            };
            let mut outbox = Outbox::default();
            for byte in &buffer[..length] {
                if let Some(answer) = self.adapter.receive(*byte, &mut outbox) {
                    self.unsent.extend_from_slice(answer.as_bytes());
                }
            }
            for frame in outbox.0 {
                bus.send(self.number, frame);
            }
        }
    }

    fn monitor(&mut self, from: Port, frame: &CanFrame, now_us: u64) {
        if from == Port::Client(self.number) {
            return;
        }
        let Some(text) = self.adapter.frame(frame, now_us) else {
            return;
        };
        if self.unsent.len() < SEND_BUFFER {
            self.unsent.extend_from_slice(text.as_bytes());
        } else {
            self.adapter.line_lost();
        }
    }

    /// Sends buffered bytes; returns whether the client is still connected.
    fn write(&mut self) -> bool {
        while !self.unsent.is_empty() {
            match self.stream.write(&self.unsent) {
                Ok(0) => return self.is_permanent,
                Ok(length) => drop(self.unsent.drain(..length)),
                Err(error) if is_temporary(&error) => return true,
                Err(_) => return self.is_permanent,
            }
        }
        true
    }
}

fn is_temporary(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted
    )
}

/// A bus and its clients.
pub struct Server<'a> {
    bus: Bus<'a>,
    clients: Vec<Client>,
    next_number: u64,
    start: Instant,
}

impl<'a> Server<'a> {
    /// A server without clients.
    pub fn new(bus: Bus<'a>) -> Self {
        Self {
            bus,
            clients: Vec::new(),
            next_number: 0,
            start: Instant::now(),
        }
    }

    /// Adds a client with a non-blocking stream; a permanent one is not removed when its reader
    /// closes it.
    pub fn add(&mut self, stream: impl Stream + 'static, is_permanent: bool) {
        let client = Client::new(self.next_number, Box::new(stream), is_permanent);
        self.next_number += 1;
        self.clients.push(client);
    }

    /// Runs the bus in real time until `stop` is set.
    ///
    /// # Errors
    /// The error of the listening socket.
    pub fn run(&mut self, listener: Option<&TcpListener>, stop: &AtomicBool) -> io::Result<()> {
        while !stop.load(Ordering::Relaxed) {
            while let Some(stream) = listener.map_or(Ok(None), accept)? {
                self.add(stream, false);
            }
            self.poll();
            std::thread::sleep(POLL_PERIOD);
        }
        Ok(())
    }

    fn poll(&mut self) {
        let Self {
            bus,
            clients,
            start,
            ..
        } = self;
        let now_us = start.elapsed().as_micros() as u64;
        clients.retain_mut(|client| client.read(bus));
        bus.run(now_us, |from, frame| {
            for client in &mut *clients {
                client.monitor(from, frame, now_us);
            }
        });
        clients.retain_mut(Client::write);
    }
}

/// The next client that connects, if there is one.
fn accept(listener: &TcpListener) -> io::Result<Option<TcpStream>> {
    match listener.accept() {
        Ok((stream, _)) => {
            stream.set_nonblocking(true)?;
            stream.set_nodelay(true)?;
            Ok(Some(stream))
        }
        Err(error) if is_temporary(&error) => Ok(None),
        Err(error) => Err(error),
    }
}
