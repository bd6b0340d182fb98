//! A CANopen client that loads an image into a node, driven by a script.

use virtual_board::run::View;

use crate::frames::{Frame, from_wire, sdo, to_wire};

/// What a request was answered with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Answer {
    /// It was carried out; the value that was read, or 0.
    Done(u32),
    /// It was refused with this abort code.
    Aborted(u32),
}

/// Where a download is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Step {
    Begin,
    /// A block that begins with this byte and has so many segments was sent.
    Block(usize, usize),
    End,
}

/// The client of one node: one request at a time.
#[derive(Debug, Default)]
pub struct Client {
    pending: bool,
    download: Option<(Vec<u8>, Step)>,
    /// Boot-up messages, each with its time, ns.
    pub boot_ups: Vec<u64>,
}

impl Client {
    /// Whether a request has no answer yet.
    pub fn is_busy(&self) -> bool {
        self.pending
    }

    /// Sends a request: an SDO of one frame.
    pub fn ask(&mut self, view: &mut View<'_>, request: [u8; 8]) {
        self.pending = true;
        send(view, sdo(request));
    }

    /// Starts to load an image to 1F50h:1, by block transfer.
    pub fn load(&mut self, view: &mut View<'_>, image: &[u8]) {
        let [a, b, c, d] = (image.len() as u32).to_le_bytes();
        self.download = Some((image.to_vec(), Step::Begin));
        self.ask(view, [0xc2, 0x50, 0x1f, 1, a, b, c, d]);
    }

    /// Gives up: the node does not answer any more.
    pub fn give_up(&mut self) {
        self.pending = false;
        self.download = None;
    }

    /// Takes what the node has sent; returns the answer to the request, if it has come.
    pub fn poll(&mut self, view: &mut View<'_>) -> Option<Answer> {
        let received = view.port(0)?.take_received();
        let mut answer = None;
        for (at_ns, frame) in &received {
            let frame = from_wire(frame);
            match (frame.raw_id().0, frame.bytes()) {
                (0x701, [0, ..]) => self.boot_ups.push(*at_ns),
                (0x581, bytes) => {
                    answer = self.answered(view, bytes).or(answer);
                }
                _ => {}
            }
        }
        answer
    }

    fn answered(&mut self, view: &mut View<'_>, bytes: [u8; 8]) -> Option<Answer> {
        let [command, _, _, _, a, b, c, d] = bytes;
        let value = u32::from_le_bytes([a, b, c, d]);
        if command == 0x80 {
            self.give_up();
            return Some(Answer::Aborted(value));
        }
        let Some((image, step)) = &mut self.download else {
            self.pending = false;
            return Some(Answer::Done(value));
        };
        let (confirmed, segments) = match *step {
            Step::End => {
                self.give_up();
                return Some(Answer::Done(0));
            }
            Step::Begin => (0, bytes[4]),
            Step::Block(start, count) => {
                assert!(usize::from(bytes[1]) <= count);
                (start + 7 * usize::from(bytes[1]), bytes[2])
            }
        };
        let Some(rest) = image.get(confirmed..).filter(|rest| !rest.is_empty()) else {
            let unused = (confirmed - image.len()) as u8;
            *step = Step::End;
            send(view, sdo([0xc1 | unused << 2, 0, 0, 0, 0, 0, 0, 0]));
            return None;
        };
        let total = rest.len().div_ceil(7);
        let chunks = rest.chunks(7).take(usize::from(segments));
        *step = Step::Block(confirmed, chunks.len());
        for (number, bytes) in chunks.enumerate() {
            let mut data = [0; 8];
            let is_last = number + 1 == total;
            data[0] = (number as u8 + 1) | if is_last { 0x80 } else { 0 };
            data[1..=bytes.len()].copy_from_slice(bytes);
            send(view, sdo(data));
        }
        None
    }
}

/// Sends a frame.
pub fn send(view: &mut View<'_>, frame: Frame) {
    let now_ns = view.now_ns();
    if let Some(port) = view.port(0) {
        port.send(now_ns, to_wire(&frame));
    }
}

/// The request to install what is staged, 1F51h:1.
pub const INSTALL: [u8; 8] = [0x2f, 0x51, 0x1f, 1, 1, 0, 0, 0];

/// The request for the flash status, 1F57h:1.
pub const STATUS: [u8; 8] = [0x40, 0x57, 0x1f, 1, 0, 0, 0, 0];

/// The request for the identity of the program, 1F56h:1.
pub const IDENTITY: [u8; 8] = [0x40, 0x56, 0x1f, 1, 0, 0, 0, 0];
