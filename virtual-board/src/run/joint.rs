//! Several boards on one bus, each in a run and a thread of its own.
//!
//! What is on the wire of one goes out on the wires of the others one to two PWM periods later, by a port that
//! each of them keeps for that. So every controller acknowledges, arbitrates and fails on its own wire, against
//! the frames of all: who wins against whom may differ from a wire that all share, by that delay.
//!
//! Virtual time joins the runs: none gets ahead of another by more than a period before it has that one's
//! frames. The same programs and scripts give the same traces, however the threads take turns.

use std::sync::mpsc::{Receiver, Sender, channel};

use super::view::{Flow, Script, View};
use crate::can::Frame;

/// How far a run may be ahead of what it has of the others, ns: a PWM period.
const AHEAD_NS: u64 = 1_000_000;

/// What a board heard on its wire up to an instant.
#[derive(Debug)]
struct Heard {
    until_ns: u64,
    frames: Vec<Frame>,
}

/// Another board.
#[derive(Debug)]
struct Peer {
    to: Sender<Heard>,
    from: Receiver<Heard>,
    /// Up to when its frames are here.
    known_until_ns: u64,
}

/// A board's end of the bus, for its script to hold.
#[derive(Debug)]
pub struct Joint {
    port: usize,
    peers: Vec<Peer>,
    /// From here on the board is on the common bus, ns; before, it is alone with its other ports.
    from_ns: u64,
}

/// Joins so many boards from this instant on, ns; `port` is the one that each has to keep for the others, among those of
/// [`Options::ports_bit_s`](super::Options::ports_bit_s).
pub fn join(boards: usize, port: usize, from_ns: u64) -> Vec<Joint> {
    let mut joints: Vec<Joint> = (0..boards)
        .map(|_| Joint {
            port,
            peers: Vec::new(),
            from_ns,
        })
        .collect();
    for one in 0..boards {
        for other in one + 1..boards {
            let (there, from_one) = channel();
            let (back, from_other) = channel();
            joints[one].peers.push(Peer::new(there, from_other));
            joints[other].peers.push(Peer::new(back, from_one));
        }
    }
    joints
}

impl Peer {
    fn new(to: Sender<Heard>, from: Receiver<Heard>) -> Self {
        Self {
            to,
            from,
            known_until_ns: 0,
        }
    }

    /// Waits until its frames up to an instant are here. A board whose run is over says nothing more.
    fn wait_until(&mut self, ns: u64) -> Vec<Frame> {
        let mut frames = Vec::new();
        while self.known_until_ns < ns {
            match self.from.recv() {
                Ok(heard) => {
                    self.known_until_ns = heard.until_ns;
                    frames.extend(heard.frames);
                }
                Err(_) => self.known_until_ns = u64::MAX,
            }
        }
        frames
    }
}

impl Joint {
    /// Passes on what was heard, and sends what the others heard: once in each PWM period.
    ///
    /// # Panics
    /// If the board has no such port: the others would wait for ever.
    pub fn exchange(&mut self, view: &mut View<'_>) {
        let now_ns = view.now_ns();
        let number = self.port;
        let Some(port) = view.port(number) else {
            panic!("a joined board keeps port {number} for the others, and this one has none");
        };
        let heard = port.take_heard();
        if now_ns < self.from_ns {
            return;
        }
        let frames: Vec<Frame> = heard.iter().map(|(_, frame)| *frame).collect();
        for peer in &mut self.peers {
            let until_ns = now_ns;
            let frames = frames.clone();
            // One whose run is over hears nothing more.
            let _ = peer.to.send(Heard { until_ns, frames });
            for frame in peer.wait_until(now_ns.saturating_sub(AHEAD_NS).max(self.from_ns)) {
                port.send(now_ns, frame);
            }
        }
    }
}

/// A script on a joined board.
#[derive(Debug)]
pub struct Joined<S> {
    /// The script.
    pub script: S,
    /// The board's end of the bus.
    pub joint: Joint,
}

impl<S: Script> Script for Joined<S> {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        self.joint.exchange(view);
        self.script.at_edge(view)
    }
}
