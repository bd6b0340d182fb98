//! The CAN bus between a client and the emulated board. The client runs in a separate thread, and
//! virtual time passes only while it waits: its requests take the same virtual time in every run.

use std::collections::VecDeque;
use std::io::{self, ErrorKind};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::Duration;

use canopen::CanFrame;
use embedded_can::Frame as _;
use host_sim::can::link::Link;
use virtual_board::can::{Frame, Id};
use virtual_board::run::{Flow, View};

/// A request of the client to the emulated board.
#[derive(Debug)]
pub(super) enum Request {
    /// Send a frame to the board.
    Send(CanFrame),
    /// Continue until the board sends a frame, or this time has passed.
    Wait(Duration),
    /// Send servo pulses of this width, us; `None` ends them.
    Servo(Option<f64>),
    /// Show this commanded angle, deg.
    ShowTarget(f64),
    /// Continue without this client, which takes no more frames.
    Leave,
    /// End the run.
    End,
}

/// The client's side of the link.
#[derive(Debug)]
pub(super) struct VirtualLink {
    requests: Sender<Request>,
    frames: Receiver<Vec<CanFrame>>,
    received: VecDeque<CanFrame>,
}

/// The emulated board's side of the link.
#[derive(Debug)]
pub(super) struct BoardLink {
    requests: Receiver<Request>,
    frames: Sender<Vec<CanFrame>>,
    sent: Vec<CanFrame>,
    /// The client waits until this instant, ns; `None` before its first wait.
    until_ns: Option<u64>,
    /// The client has left, or ended.
    is_alone: bool,
    /// The commanded angle to be shown, deg.
    pub target_deg: Option<f64>,
}

/// Both sides of a link, and a sender of further requests.
pub(super) fn connect() -> (VirtualLink, Sender<Request>, BoardLink) {
    let (requests, requested) = channel();
    let (sent, frames) = channel();
    let link = VirtualLink {
        requests: requests.clone(),
        frames,
        received: VecDeque::new(),
    };
    let board = BoardLink {
        requests: requested,
        frames: sent,
        sent: Vec::new(),
        until_ns: None,
        is_alone: false,
        target_deg: None,
    };
    (link, requests, board)
}

/// Error after the end of the run.
fn ended() -> io::Error {
    io::Error::new(ErrorKind::BrokenPipe, "the run has ended")
}

impl Link for VirtualLink {
    fn send(&mut self, frame: &CanFrame) -> io::Result<()> {
        let sent = self.requests.send(Request::Send(*frame));
        sent.map_err(|_| ended())
    }

    fn receive(&mut self, timeout: Duration) -> io::Result<Option<CanFrame>> {
        if self.received.is_empty() {
            let sent = self.requests.send(Request::Wait(timeout));
            sent.map_err(|_| ended())?;
            self.received = self.frames.recv().map_err(|_| ended())?.into();
        }
        Ok(self.received.pop_front())
    }

    /// Discards the received frames. A pause without an end lasts to the end of the run: the board
    /// does not wait at each of its frames for a thread that only discards them.
    fn pause(&mut self, time: Duration) -> io::Result<()> {
        self.received.clear();
        if time < Duration::MAX {
            return self.receive(time).map(drop);
        }
        self.requests.send(Request::Leave).map_err(|_| ended())?;
        while self.frames.recv().is_ok() {}
        Err(ended())
    }
}

impl BoardLink {
    /// Forwards the frames of the board, and runs the client until it waits again.
    pub fn exchange(&mut self, view: &mut View<'_>, sent: &[(u64, Frame)]) -> Flow {
        if self.is_alone {
            return Flow::Continue;
        }
        let now_ns = view.now_ns();
        self.sent
            .extend(sent.iter().filter_map(|(_, frame)| from_wire(frame)));
        if let Some(until_ns) = self.until_ns {
            if self.sent.is_empty() && now_ns < until_ns {
                return Flow::Continue;
            }
            // A client that has ended receives nothing.
            let _ = self.frames.send(std::mem::take(&mut self.sent));
        }
        while let Ok(request) = self.requests.recv() {
            match request {
                Request::Send(frame) => {
                    if let Some(port) = view.port(0) {
                        port.send(now_ns, to_wire(&frame));
                    }
                }
                Request::Wait(time) => {
                    let wait_ns = u64::try_from(time.as_nanos()).unwrap_or(u64::MAX);
                    self.until_ns = Some(now_ns.saturating_add(wait_ns));
                    return Flow::Continue;
                }
                Request::Servo(pulse_us) => view.set_servo_us(pulse_us),
                Request::ShowTarget(deg) => self.target_deg = Some(deg),
                Request::Leave => break,
                Request::End => return Flow::End,
            }
        }
        // The board continues without the client.
        self.is_alone = true;
        Flow::Continue
    }
}

fn to_wire(frame: &CanFrame) -> Frame {
    let id = match frame.raw_id() {
        (id, true) => Id::Extended(id),
        (id, false) => Id::Standard(id as u16),
    };
    Frame::data_frame(id, frame.data())
}

fn from_wire(frame: &Frame) -> Option<CanFrame> {
    let is_extended = matches!(frame.id, Id::Extended(_));
    let length = frame.payload().len() as u8;
    CanFrame::raw(frame.id.value(), is_extended, false, length, frame.data)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pause_without_an_end_leaves_the_board_alone_until_the_run_ends() {
        let (mut link, _requests, board) = connect();
        let pausing = std::thread::spawn(move || link.pause(Duration::MAX));
        // Only this request: the client requests no frame that it would discard.
        assert!(matches!(board.requests.recv(), Ok(Request::Leave)));
        drop(board);
        let ended = pausing
            .join()
            .expect("no panic")
            .expect_err("the run has ended");
        assert_eq!(ended.kind(), ErrorKind::BrokenPipe);
    }
}
