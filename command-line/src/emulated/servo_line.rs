//! The one wire of a servo bus: the client and the boards.
//!
//! Whatever one of them sends, all others hear, and nobody hears itself. The wire keeps no time:
//! the serial port of each board takes the time of the bytes that it sends and receives. Bytes that
//! are sent at once do not destroy each other, as they would on a real wire; a board that transmits
//! hears none of them.

use super::transport::Transport;

/// Bytes that wait for a board before the client has to wait: the operating system buffers more.
const RECEIVE_BUFFER: usize = 256;

/// Bytes that wait for a client; further ones are lost.
const SEND_BUFFER: usize = 1 << 16;

/// Time between the bytes of a board and those of the client, ns: less than an adapter and the
/// operating system need. The client itself takes real time, in which the emulation may stand
/// still.
const TURNAROUND_NS: u64 = 100_000;

/// The wire.
pub struct ServoLine {
    transport: Box<dyn Transport>,
    /// What the client has not read.
    unread: Vec<u8>,
    boards: Vec<Unheard>,
    /// The client may send from then on, ns.
    free_from_ns: u64,
    /// The client is not on the line yet: it hears and sends nothing.
    is_rehearsal: bool,
}

/// What a board has not heard.
#[derive(Debug, Clone, Default)]
struct Unheard {
    bytes: Vec<u8>,
    /// Number of further bytes that wait in front of its serial port.
    queued: usize,
}

impl ServoLine {
    /// A wire of so many boards and the client of this transport.
    pub fn new(transport: Box<dyn Transport>, boards: usize) -> Self {
        Self {
            transport,
            unread: Vec::new(),
            boards: vec![Unheard::default(); boards],
            free_from_ns: 0,
            is_rehearsal: false,
        }
    }

    /// What this board has sent, and the number of bytes that its serial port has still to receive.
    pub fn send(&mut self, now_ns: u64, board: usize, bytes: &[u8], queued: usize) {
        for (index, other) in self.boards.iter_mut().enumerate() {
            if index == board {
                other.queued = queued;
            } else {
                other.bytes.extend(bytes);
            }
        }
        if self.is_rehearsal {
            return;
        }
        let room = SEND_BUFFER.saturating_sub(self.unread.len());
        self.unread.extend(bytes.iter().take(room));
        if !bytes.is_empty() {
            self.free_from_ns = self.free_from_ns.max(now_ns + TURNAROUND_NS);
            self.transport.write(&mut self.unread);
        }
    }

    /// Sends a packet to all boards in place of the client, which takes its place with `None`.
    pub fn rehearse(&mut self, packet: Option<&[u8]>) {
        self.is_rehearsal = packet.is_some();
        for board in &mut self.boards {
            board.bytes.extend(packet.unwrap_or_default());
        }
    }

    /// What this board hears next.
    pub fn take(&mut self, board: usize) -> Vec<u8> {
        let Some(unheard) = self.boards.get_mut(board) else {
            return Vec::new();
        };
        unheard.queued += unheard.bytes.len();
        std::mem::take(&mut unheard.bytes)
    }

    /// Takes what the client has sent, unless a board has just sent, or has still to hear what came
    /// before; gives the client what it has not read.
    pub fn serve_client(&mut self, now_ns: u64) {
        if !self.unread.is_empty() {
            self.transport.write(&mut self.unread);
        }
        if self.is_rehearsal || now_ns < self.free_from_ns {
            return;
        }
        let waiting = self.boards.iter().map(Unheard::count).max();
        if waiting.is_some_and(|count| count < RECEIVE_BUFFER) {
            let mut bytes = [0; RECEIVE_BUFFER];
            let count = self.transport.read(&mut bytes);
            let bytes = bytes.get(..count).unwrap_or_default();
            for board in &mut self.boards {
                board.bytes.extend(bytes);
            }
        }
    }
}

impl Unheard {
    fn count(&self) -> usize {
        self.bytes.len() + self.queued
    }
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use super::*;

    /// Behind all turnarounds.
    const NOW_NS: u64 = TURNAROUND_NS;

    /// A client that has written bytes, and reads so many.
    #[derive(Clone, Default)]
    struct Client(Arc<Mutex<Ends>>);

    #[derive(Default)]
    struct Ends {
        written: Vec<u8>,
        read: Vec<u8>,
        reads: usize,
    }

    impl Client {
        fn with<T>(&self, act: impl FnOnce(&mut Ends) -> T) -> T {
            act(&mut self.0.lock().expect("no test fails within"))
        }

        fn write(&self, bytes: &[u8]) {
            self.with(|ends| ends.written.extend(bytes));
        }
    }

    impl Transport for Client {
        fn read(&mut self, bytes: &mut [u8]) -> usize {
            self.with(|ends| {
                let count = ends.written.len().min(bytes.len());
                for (to, from) in bytes.iter_mut().zip(ends.written.drain(..count)) {
                    *to = from;
                }
                count
            })
        }

        fn write(&mut self, bytes: &mut Vec<u8>) {
            self.with(|ends| {
                let count = bytes.len().min(ends.reads);
                ends.reads -= count;
                ends.read.extend(bytes.drain(..count));
            });
        }
    }

    fn line() -> (Client, ServoLine) {
        let client = Client::default();
        let line = ServoLine::new(Box::new(client.clone()), 2);
        (client, line)
    }

    #[test]
    fn each_hears_all_others_and_not_itself() {
        let (client, mut line) = line();
        client.with(|ends| ends.reads = 100);
        client.write(&[1, 2]);
        line.serve_client(NOW_NS);
        assert_eq!([line.take(0), line.take(1)], [[1, 2], [1, 2]]);
        line.send(0, 0, &[3], 0);
        line.send(0, 1, &[4], 0);
        assert_eq!([line.take(0), line.take(1)], [[4], [3]]);
        assert_eq!(client.with(|ends| ends.read.clone()), [3, 4]);
        line.serve_client(NOW_NS);
        assert!(line.take(0).is_empty() && line.take(1).is_empty());
    }

    #[test]
    fn the_client_is_not_there_in_a_rehearsal() {
        let (client, mut line) = line();
        client.with(|ends| ends.reads = 100);
        client.write(&[1]);
        line.rehearse(Some(&[2]));
        line.send(0, 0, &[3], 0);
        line.serve_client(NOW_NS);
        assert_eq!([line.take(0), line.take(1)], [vec![2], vec![2, 3]]);
        line.rehearse(None);
        line.serve_client(NOW_NS);
        assert_eq!(line.take(0), [1]);
        assert!(client.with(|ends| ends.read.is_empty()));
    }

    #[test]
    fn the_client_sends_after_a_turnaround() {
        let (client, mut line) = line();
        line.send(5_000, 1, &[3], 0);
        client.write(&[1]);
        line.serve_client(4_999 + TURNAROUND_NS);
        assert_eq!(line.take(0), [3]);
        line.serve_client(5_000 + TURNAROUND_NS);
        assert_eq!(line.take(0), [1]);
    }

    #[test]
    fn a_client_that_does_not_read_loses_bytes_and_stops_nobody() {
        let (client, mut line) = line();
        let many: Vec<u8> = (0..=u8::MAX).collect();
        for _ in 0..300 {
            line.send(0, 0, &many, 0);
            assert_eq!(line.take(1), many);
            line.send(0, 1, &[], 0);
        }
        client.write(&[7]);
        line.serve_client(NOW_NS);
        assert_eq!(line.take(0), [7]);
        client.with(|ends| ends.reads = usize::MAX);
        line.serve_client(NOW_NS);
        assert_eq!(client.with(|ends| ends.read.len()), SEND_BUFFER);
    }

    #[test]
    fn a_client_that_sends_more_than_the_line_carries_waits() {
        let (client, mut line) = line();
        client.write(&[5; 1000]);
        let left = |line: &mut ServoLine| {
            line.serve_client(NOW_NS);
            client.with(|ends| ends.written.len())
        };
        assert_eq!(left(&mut line), 1000 - RECEIVE_BUFFER);
        let [one, other] = [line.take(0).len(), line.take(1).len()];
        assert_eq!([one, other], [RECEIVE_BUFFER; 2]);
        // The ports have not received them, or only one has.
        line.send(0, 0, &[], 0);
        assert_eq!(left(&mut line), 1000 - RECEIVE_BUFFER);
        line.send(0, 1, &[], 1);
        assert_eq!(left(&mut line), 1000 - 2 * RECEIVE_BUFFER);
    }
}
