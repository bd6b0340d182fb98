//! Transports between the emulated serial line and its client.

use std::fs::File;
use std::io::{ErrorKind, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};

/// A non-blocking transport to the serial line.
pub trait Transport: Send {
    /// Reads bytes of the client; returns their number.
    fn read(&mut self, bytes: &mut [u8]) -> usize;

    /// Sends bytes to the client and removes them; without a client, all are removed.
    fn write(&mut self, bytes: &mut Vec<u8>);
}

/// Whether the operation would block.
fn is_temporary(kind: ErrorKind) -> bool {
    matches!(
        kind,
        ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted
    )
}

/// Writes as much as possible without blocking; returns whether the peer is still connected.
fn write_some(mut line: impl Write, bytes: &mut Vec<u8>) -> bool {
    while !bytes.is_empty() {
        match line.write(bytes) {
            Ok(0) => return false,
            Ok(count) => drop(bytes.drain(..count)),
            Err(error) => return is_temporary(error.kind()),
        }
    }
    true
}

/// A pseudo-terminal, which remains open when its reader closes it.
pub struct Terminal(pub File);

impl Transport for Terminal {
    fn read(&mut self, bytes: &mut [u8]) -> usize {
        self.0.read(bytes).unwrap_or(0)
    }

    fn write(&mut self, bytes: &mut Vec<u8>) {
        if !write_some(&self.0, bytes) {
            bytes.clear();
        }
    }
}

/// A TCP server for one client at a time: further ones are refused.
pub struct TcpServer {
    listener: TcpListener,
    client: Option<TcpStream>,
    /// What has one client at a time.
    what: &'static str,
}

impl TcpServer {
    /// A server of this serial line, with a non-blocking listener.
    pub fn new(listener: TcpListener, what: &'static str) -> Self {
        Self {
            listener,
            client: None,
            what,
        }
    }

    fn accept_client(&mut self) {
        let Ok((stream, address)) = self.listener.accept() else {
            return;
        };
        if self.client.is_some() {
            note!("{address} is refused: {} has a client", self.what);
            // The refused client may have disconnected already.
            let _ = stream.shutdown(Shutdown::Both);
            return;
        }
        let is_ready = stream
            .set_nonblocking(true)
            .and_then(|()| stream.set_nodelay(true));
        self.client = is_ready.is_ok().then_some(stream);
    }
}

impl Transport for TcpServer {
    fn read(&mut self, bytes: &mut [u8]) -> usize {
        if let Some(client) = &mut self.client {
            match client.read(bytes) {
                Ok(count) if count > 0 => return count,
                Err(error) if is_temporary(error.kind()) => {}
                _ => self.client = None,
            }
        }
        // After the read, which detects a client that has disconnected.
        self.accept_client();
        0
    }

    fn write(&mut self, bytes: &mut Vec<u8>) {
        let is_there = self
            .client
            .as_ref()
            .is_some_and(|client| write_some(client, bytes));
        if !is_there {
            bytes.clear();
            self.client = None;
        }
    }
}
