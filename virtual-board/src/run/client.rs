//! A client of the CAN bus in a separate thread. Virtual time passes only while it waits: its
//! requests take the same virtual time in every run.

use std::collections::VecDeque;
use std::io::{self, ErrorKind};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::Duration;

use super::view::{Flow, View};
use crate::can::Frame;

/// An action on the run.
type Action = Box<dyn FnOnce(&mut View<'_>) + Send>;

/// A request of the client to the run.
enum Request {
    /// Send a frame to the board.
    Send(Frame),
    /// Continue until the board sends a frame, or this time has passed.
    Receive(Duration),
    /// Continue for this time, without the frames of the board.
    Pause(Duration),
    /// Act on the run.
    Act(Action),
    /// Continue without this client, which takes no more frames.
    Leave,
    /// End the run.
    End,
}

/// The client's side.
#[derive(Debug)]
pub struct ClientSide {
    requests: Requests,
    frames: Receiver<Vec<Frame>>,
    received: VecDeque<Frame>,
}

/// Requests to the run beside those for the bus. They take effect when the client does not wait, in
/// the order of all its requests, and not after a pause without an end.
#[derive(Debug, Clone)]
pub struct Requests(Sender<Request>);

/// The run's side, which a [`Script`](super::Script) calls at each edge.
#[derive(Debug)]
pub struct RunSide {
    requests: Receiver<Request>,
    frames: Sender<Vec<Frame>>,
    sent: Vec<Frame>,
    wait: Wait,
}

/// What the client waits for, until an instant, ns.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Wait {
    /// Nothing: it has not begun to wait.
    No,
    /// A frame.
    Frame(u64),
    /// The instant alone.
    Pause(u64),
    /// The end of the run.
    End,
}

/// Both sides.
pub fn client() -> (ClientSide, RunSide) {
    let (requests, requested) = channel();
    let (sent, frames) = channel();
    let client = ClientSide {
        requests: Requests(requests),
        frames,
        received: VecDeque::new(),
    };
    let run = RunSide {
        requests: requested,
        frames: sent,
        sent: Vec::new(),
        wait: Wait::No,
    };
    (client, run)
}

/// Error after the end of the run.
fn ended() -> io::Error {
    io::Error::new(ErrorKind::BrokenPipe, "the run has ended")
}

impl Requests {
    fn request(&self, request: Request) -> io::Result<()> {
        self.0.send(request).map_err(|_| ended())
    }

    /// Acts on the run.
    ///
    /// # Errors
    /// The run has ended.
    pub fn act(&self, action: impl FnOnce(&mut View<'_>) + Send + 'static) -> io::Result<()> {
        self.request(Request::Act(Box::new(action)))
    }

    /// Ends the run.
    ///
    /// # Errors
    /// The run has ended.
    pub fn end(&self) -> io::Result<()> {
        self.request(Request::End)
    }
}

impl ClientSide {
    /// Requests beside those for the bus.
    pub fn requests(&self) -> Requests {
        self.requests.clone()
    }

    /// Sends a frame to the board.
    ///
    /// # Errors
    /// The run has ended.
    pub fn send(&self, frame: Frame) -> io::Result<()> {
        self.requests.request(Request::Send(frame))
    }

    /// The next frame of the board, if it sends one within this virtual time.
    ///
    /// # Errors
    /// The run has ended.
    pub fn receive(&mut self, timeout: Duration) -> io::Result<Option<Frame>> {
        if self.received.is_empty() {
            self.requests.request(Request::Receive(timeout))?;
            self.received = self.frames.recv().map_err(|_| ended())?.into();
        }
        Ok(self.received.pop_front())
    }

    /// Lets this virtual time pass, and discards the frames of the board. A pause without an end
    /// lasts to the end of the run: the board does not wait at each of its frames for a thread that
    /// only discards them.
    ///
    /// # Errors
    /// The run has ended.
    pub fn pause(&mut self, time: Duration) -> io::Result<()> {
        self.received.clear();
        if time < Duration::MAX {
            self.requests.request(Request::Pause(time))?;
            return self.frames.recv().map(drop).map_err(|_| ended());
        }
        self.requests.request(Request::Leave)?;
        while self.frames.recv().is_ok() {}
        Err(ended())
    }
}

impl RunSide {
    /// Forwards the frames of the board since the last call, and runs the client until it waits
    /// again.
    pub fn exchange(&mut self, view: &mut View<'_>, sent: impl IntoIterator<Item = Frame>) -> Flow {
        let now_ns = view.now_ns();
        self.sent.extend(sent);
        let is_waiting = match self.wait {
            Wait::No => false,
            Wait::Frame(until_ns) => self.sent.is_empty() && now_ns < until_ns,
            Wait::Pause(until_ns) => now_ns < until_ns,
            Wait::End => true,
        };
        if is_waiting {
            if !matches!(self.wait, Wait::Frame(_)) {
                self.sent.clear();
            }
            return Flow::Continue;
        }
        if self.wait != Wait::No {
            // A client that has ended receives nothing.
            let _ = self.frames.send(std::mem::take(&mut self.sent));
        }
        self.serve(view, now_ns)
    }

    fn serve(&mut self, view: &mut View<'_>, now_ns: u64) -> Flow {
        let until_ns = |time: Duration| {
            let ns = u64::try_from(time.as_nanos()).unwrap_or(u64::MAX);
            now_ns.saturating_add(ns)
        };
        while let Ok(request) = self.requests.recv() {
            self.wait = match request {
                Request::Receive(time) => Wait::Frame(until_ns(time)),
                Request::Pause(time) => Wait::Pause(until_ns(time)),
                Request::Leave => Wait::End,
                Request::End => return Flow::End,
                Request::Act(action) => {
                    action(view);
                    continue;
                }
                Request::Send(frame) => {
                    if let Some(port) = view.port(0) {
                        port.send(now_ns, frame);
                    }
                    continue;
                }
            };
            return Flow::Continue;
        }
        // The board continues without the client.
        self.wait = Wait::End;
        Flow::Continue
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pause_without_an_end_leaves_the_board_alone_until_the_run_ends() {
        let (mut client, run) = client();
        let pausing = std::thread::spawn(move || client.pause(Duration::MAX));
        // Only this request: the client requests no frame that it would discard.
        assert!(matches!(run.requests.recv(), Ok(Request::Leave)));
        drop(run);
        let ended = pausing
            .join()
            .expect("no panic")
            .expect_err("the run has ended");
        assert_eq!(ended.kind(), ErrorKind::BrokenPipe);
    }
}
