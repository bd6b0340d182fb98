//! One client: its stream, its slcan adapter, and its bounded queues.

use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};
use std::sync::mpsc::{SyncSender, TrySendError};
use std::time::{Duration, Instant};

use canopen::CanFrame;
use canopen::slcan::{self, Adapter};
use mio::event::Source;

use super::nodes::Traffic;
use super::notice::Notice;
use crate::can::bus::Port;

/// Bytes of frames that wait until the client reads; further frames are lost, as at an adapter's
/// serial line.
const FRAMES_BYTES: usize = 1 << 18;

/// Bytes of frames and answers that wait; further answers are lost.
const UNSENT_BYTES: usize = FRAMES_BYTES + (1 << 16);

/// Bytes that are read in a turn.
const TURN_BYTES: usize = 4096;

/// Frames of the client that wait for the bus. Nothing more is read while as many wait, apart from
/// those of the last turn: a line of a frame has six bytes at least.
pub const INBOX_FRAMES: usize = 512;

/// Time between two notices of the same kind about the same client.
const NOTICE_PERIOD: Duration = Duration::from_secs(10);

/// A non-blocking stream to a client.
pub trait Stream: Read + Write + Source + Send {}

impl<T: Read + Write + Source + Send> Stream for T {}

/// The bus of an adapter: a list of the frames that the client sends.
struct Outbox<'a>(&'a mut VecDeque<CanFrame>);

impl slcan::Bus for Outbox<'_> {
    /// The virtual bus has no bit rate: any is accepted.
    fn open(&mut self, _: Option<u16>, _: bool) -> bool {
        true
    }

    fn close(&mut self) {}

    fn send(&mut self, frame: &CanFrame) -> bool {
        self.0.push_back(*frame);
        true
    }

    fn flags(&mut self) -> u8 {
        0
    }
}

/// One client.
pub struct Client {
    number: u64,
    name: String,
    stream: Box<dyn Stream>,
    adapter: Adapter,
    /// The way to the bus.
    inbox: SyncSender<CanFrame>,
    /// Frames for which the inbox has no room.
    unsent_frames: VecDeque<CanFrame>,
    /// Bytes for the client.
    unsent: VecDeque<u8>,
    /// A terminal remains open when its reader closes it.
    is_permanent: bool,
    is_readable: bool,
    is_writable: bool,
    has_ended: bool,
    slowed: Option<Instant>,
    losing: Option<Instant>,
    /// Lines lost since the client last read all.
    lost_lines: u64,
}

impl Client {
    /// A client whose frames go to `inbox`.
    pub fn new(
        number: u64,
        name: String,
        stream: Box<dyn Stream>,
        is_permanent: bool,
        inbox: SyncSender<CanFrame>,
    ) -> Self {
        Self {
            number,
            name,
            stream,
            adapter: Adapter::new(*b"0001"),
            inbox,
            unsent_frames: VecDeque::new(),
            unsent: VecDeque::new(),
            is_permanent,
            is_readable: true,
            is_writable: true,
            has_ended: false,
            slowed: None,
            losing: None,
            lost_lines: 0,
        }
    }

    /// Its number.
    pub fn number(&self) -> u64 {
        self.number
    }

    /// Its stream, which is registered for events.
    pub fn stream(&mut self) -> &mut dyn Source {
        &mut self.stream
    }

    /// The stream may have become readable or writable.
    pub fn has_event(&mut self, is_readable: bool, is_writable: bool) {
        self.is_readable |= is_readable;
        self.is_writable |= is_writable;
    }

    /// Whether it may be read at once.
    pub fn wants_turn(&self) -> bool {
        self.is_readable && !self.has_ended && self.unsent_frames.is_empty()
    }

    /// Whether it waits for room in its inbox.
    pub fn waits_for_bus(&self) -> bool {
        !self.unsent_frames.is_empty()
    }

    /// Whether it has disconnected and all its frames are on their way.
    pub fn is_gone(&self) -> bool {
        self.has_ended && self.unsent_frames.is_empty()
    }

    /// Passes frames to the bus, reads a part of what it sent, and handles the commands; returns
    /// whether the bus got a frame.
    pub fn take_turn(&mut self, notify: &mut dyn FnMut(&Notice)) -> bool {
        let mut has_sent = self.pass_frames();
        if self.wants_turn() {
            self.read();
            has_sent |= self.pass_frames();
            if self.waits_for_bus() && is_due(&mut self.slowed) {
                notify(&Notice::Slowed {
                    client: self.name.clone(),
                });
            }
        }
        has_sent
    }

    fn pass_frames(&mut self) -> bool {
        let mut has_sent = false;
        while let Some(frame) = self.unsent_frames.front() {
            match self.inbox.try_send(*frame) {
                Ok(()) => has_sent = true,
                Err(TrySendError::Full(_)) => break,
                // The server ends.
                Err(TrySendError::Disconnected(_)) => {}
            }
            self.unsent_frames.pop_front();
        }
        has_sent
    }

    fn read(&mut self) {
        let mut buffer = [0; TURN_BYTES];
        let length = match self.stream.read(&mut buffer) {
            Err(error) if error.kind() == ErrorKind::Interrupted => return,
            Err(error) if error.kind() == ErrorKind::WouldBlock => 0,
            Ok(length) if length > 0 => length,
            Ok(_) | Err(_) => {
                self.has_ended = !self.is_permanent;
                0
            }
        };
        self.is_readable = length > 0;
        for byte in &buffer[..length] {
            let mut outbox = Outbox(&mut self.unsent_frames);
            if let Some(answer) = self.adapter.receive(*byte, &mut outbox) {
                self.push(answer.as_bytes(), UNSENT_BYTES);
            }
        }
    }

    /// A frame of the bus for the client.
    pub fn deliver(&mut self, traffic: &Traffic) {
        if traffic.from == Port::Client(self.number) {
            return;
        }
        if let Some(line) = self.adapter.frame(&traffic.frame, traffic.at_us) {
            self.push(line.as_bytes(), FRAMES_BYTES);
        }
    }

    /// Frames for the client that were lost before they reached it.
    pub fn has_lost(&mut self, lines: u64) {
        self.adapter.line_lost();
        self.lost_lines += lines;
    }

    fn push(&mut self, line: &[u8], most: usize) {
        if self.unsent.len() + line.len() > most {
            return self.has_lost(1);
        }
        self.unsent.extend(line);
    }

    /// Sends what waits.
    pub fn write(&mut self, notify: &mut dyn FnMut(&Notice)) {
        while self.is_writable && !self.unsent.is_empty() {
            match self.stream.write(self.unsent.as_slices().0) {
                Ok(length) if length > 0 => drop(self.unsent.drain(..length)),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) if error.kind() == ErrorKind::WouldBlock => self.is_writable = false,
                // What the client sent before it went is still read.
                Ok(_) | Err(_) => {
                    self.unsent.clear();
                    (self.is_writable, self.is_readable) = (false, true);
                }
            }
        }
        self.tell_losses(notify);
    }

    fn tell_losses(&mut self, notify: &mut dyn FnMut(&Notice)) {
        if self.lost_lines == 0 {
            return;
        }
        let client = || self.name.clone();
        if is_due(&mut self.losing) {
            notify(&Notice::Losing { client: client() });
        }
        if self.unsent.is_empty() || self.has_ended {
            let lines = std::mem::take(&mut self.lost_lines);
            notify(&Notice::Lost {
                client: client(),
                lines,
            });
        }
    }
}

/// Whether a notice is due, which was last given at this time.
pub fn is_due(last: &mut Option<Instant>) -> bool {
    let is_due = last.is_none_or(|last| last.elapsed() > NOTICE_PERIOD);
    if is_due {
        *last = Some(Instant::now());
    }
    is_due
}

/// A pseudo-terminal that never waits.
#[cfg(unix)]
#[derive(Debug)]
pub struct Terminal(pub std::fs::File);

#[cfg(unix)]
mod terminal {
    use std::os::fd::AsRawFd;

    use mio::{Interest, Registry, Token, event::Source, unix::SourceFd};

    use super::{Read, Terminal, Write, io};

    impl Read for Terminal {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            self.0.read(buffer)
        }
    }

    impl Write for Terminal {
        fn write(&mut self, buffer: &[u8]) -> io::Result<usize> {
            self.0.write(buffer)
        }

        fn flush(&mut self) -> io::Result<()> {
            self.0.flush()
        }
    }

    impl Source for Terminal {
        fn register(&mut self, to: &Registry, token: Token, what: Interest) -> io::Result<()> {
            SourceFd(&self.0.as_raw_fd()).register(to, token, what)
        }

        fn reregister(&mut self, to: &Registry, token: Token, what: Interest) -> io::Result<()> {
            SourceFd(&self.0.as_raw_fd()).reregister(to, token, what)
        }

        fn deregister(&mut self, from: &Registry) -> io::Result<()> {
            SourceFd(&self.0.as_raw_fd()).deregister(from)
        }
    }
}
