//! Who comes to the serial line.

use std::fs::File;
use std::io::{ErrorKind, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};

/// A way to the serial line that never waits.
pub trait Door: Send {
    /// Bytes of the client, and how many.
    fn read(&mut self, bytes: &mut [u8]) -> usize;

    /// Gives a client what it takes, and forgets that; all of it where there is none.
    fn write(&mut self, bytes: &mut Vec<u8>);
}

/// Whether an error says that there is nothing at present.
fn is_nothing(kind: ErrorKind) -> bool {
    matches!(
        kind,
        ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted
    )
}

/// Writes as much as goes at once; whether the other side is still there.
fn write_some(mut line: impl Write, bytes: &mut Vec<u8>) -> bool {
    while !bytes.is_empty() {
        match line.write(bytes) {
            Ok(0) => return false,
            Ok(count) => drop(bytes.drain(..count)),
            Err(error) => return is_nothing(error.kind()),
        }
    }
    true
}

/// A pseudo-terminal: it stays when its reader goes.
pub struct Terminal(pub File);

impl Door for Terminal {
    fn read(&mut self, bytes: &mut [u8]) -> usize {
        self.0.read(bytes).unwrap_or(0)
    }

    fn write(&mut self, bytes: &mut Vec<u8>) {
        if !write_some(&self.0, bytes) {
            bytes.clear();
        }
    }
}

/// Clients over TCP, one after the other: while one is there, others are refused.
pub struct Visitors {
    listener: TcpListener,
    client: Option<TcpStream>,
}

impl Visitors {
    /// At a listener that does not wait.
    pub fn new(listener: TcpListener) -> Self {
        Self {
            listener,
            client: None,
        }
    }

    fn let_in(&mut self) {
        let Ok((stream, address)) = self.listener.accept() else {
            return;
        };
        if self.client.is_some() {
            eprintln!(
                "{address} is refused: the serial line of the communication board has a client"
            );
            // Who is refused may be gone already.
            let _ = stream.shutdown(Shutdown::Both);
            return;
        }
        let is_ready = stream
            .set_nonblocking(true)
            .and_then(|()| stream.set_nodelay(true));
        self.client = is_ready.is_ok().then_some(stream);
    }
}

impl Door for Visitors {
    fn read(&mut self, bytes: &mut [u8]) -> usize {
        if let Some(client) = &mut self.client {
            match client.read(bytes) {
                Ok(count) if count > 0 => return count,
                Err(error) if is_nothing(error.kind()) => {}
                _ => self.client = None,
            }
        }
        // Only now: who has said goodbye is gone before the next one is looked at.
        self.let_in();
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
