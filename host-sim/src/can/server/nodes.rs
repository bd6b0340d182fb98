//! The thread of the actuators: their control periods on time, and frames of clients in between.
//!
//! It waits for nothing that a client can hold up: queues from and to the clients have bounds, and
//! what does not fit is lost and counted.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError};
use std::thread;
use std::time::{Duration, Instant};

use canopen::CanFrame;
use mio::Waker;

use super::CLIENTS_MAX;
use crate::can::bus::{Bus, Port};

/// Frames of clients that the bus carries in a control period, in equal shares: seven times as many
/// as a bus of 1 Mbit/s, where the shortest data frame with eight bytes has 111 bits.
const FRAMES_PER_PERIOD: usize = 256;

/// A frame on the bus.
pub struct Traffic {
    /// Its sender.
    pub from: Port,
    /// The frame.
    pub frame: CanFrame,
    /// Its time, us since the start of the server.
    pub at_us: u64,
}

/// The frames of a client.
pub struct Inbox {
    number: u64,
    frames: Receiver<CanFrame>,
    /// Frames that the bus still carries for it in this control period.
    budget: usize,
}

impl Inbox {
    /// What the client with this number sends.
    pub fn new(number: u64, frames: Receiver<CanFrame>) -> Self {
        let budget = FRAMES_PER_PERIOD / CLIENTS_MAX;
        Self {
            number,
            frames,
            budget,
        }
    }
}

/// What was lost on the way to the thread of the clients.
#[derive(Debug, Default)]
pub struct Losses {
    /// Frames for which the queue had no room.
    pub frames: AtomicU64,
    /// Control periods that were skipped.
    pub periods: AtomicU64,
}

/// The way to the thread of the clients.
pub struct Outlet<'s> {
    /// The queue.
    pub traffic: SyncSender<Traffic>,
    /// What was lost.
    pub losses: &'s Losses,
    /// Wakes the thread.
    pub waker: &'s Waker,
    /// Whether there is something that the thread was not woken for.
    pub is_waiting: bool,
}

impl Outlet<'_> {
    fn push(&mut self, from: Port, frame: &CanFrame, at_us: u64) {
        let frame = *frame;
        if self
            .traffic
            .try_send(Traffic { from, frame, at_us })
            .is_err()
        {
            self.losses.frames.fetch_add(1, Relaxed);
        }
        self.is_waiting = true;
    }

    fn wake(&mut self) {
        if std::mem::take(&mut self.is_waiting) {
            // It fails if the thread has ended; then this one ends too.
            let _ = self.waker.wake();
        }
    }
}

/// Whether there was a frame.
enum Passed {
    Frame,
    Nothing,
    /// The thread of the clients has ended.
    End,
}

/// The actuators, and the frames of all clients.
pub struct Nodes<'s, 'a> {
    /// The bus.
    pub bus: &'s mut Bus<'a>,
    /// Inboxes of clients that join.
    pub joining: Receiver<Inbox>,
    /// Inboxes of clients.
    pub inboxes: Vec<Inbox>,
    /// The inbox that had the last turn.
    pub turn: usize,
    /// The way to the clients.
    pub outlet: Outlet<'s>,
    /// Start of the server's time.
    pub start: Instant,
}

impl Nodes<'_, '_> {
    /// Runs until `stop` is set or the thread of the clients ends.
    pub fn run(mut self, stop: &AtomicBool) {
        while !stop.load(Relaxed) {
            let now_us = self.start.elapsed().as_micros() as u64;
            if now_us >= self.bus.next_us() {
                self.step(now_us);
                continue;
            }
            match self.pass(now_us) {
                Passed::Frame => continue,
                Passed::Nothing => self.outlet.wake(),
                Passed::End => return,
            }
            thread::park_timeout(Duration::from_micros(self.bus.next_us() - now_us));
        }
    }

    /// A control period of the actuators.
    fn step(&mut self, now_us: u64) {
        let Self { bus, outlet, .. } = self;
        let skipped = bus.skip_late(now_us);
        outlet.losses.periods.fetch_add(skipped, Relaxed);
        bus.step(now_us, |from, frame| outlet.push(from, frame, now_us));
        outlet.wake();
        let share = FRAMES_PER_PERIOD.div_ceil(self.inboxes.len().max(1));
        for inbox in &mut self.inboxes {
            inbox.budget = share;
        }
    }

    /// Passes a frame of the next client that has one, and a share left.
    fn pass(&mut self, now_us: u64) -> Passed {
        loop {
            match self.joining.try_recv() {
                Ok(inbox) => self.inboxes.push(inbox),
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) => return Passed::End,
            }
        }
        for _ in 0..self.inboxes.len() {
            self.turn = (self.turn + 1) % self.inboxes.len();
            let inbox = &mut self.inboxes[self.turn];
            if inbox.budget == 0 {
                continue;
            }
            match inbox.frames.try_recv() {
                Ok(frame) => {
                    inbox.budget -= 1;
                    let (number, outlet) = (inbox.number, &mut self.outlet);
                    self.bus.send(number, frame, |from, frame| {
                        outlet.push(from, frame, now_us);
                    });
                    return Passed::Frame;
                }
                Err(TryRecvError::Empty) => {}
                Err(TryRecvError::Disconnected) => {
                    self.inboxes.remove(self.turn);
                    // The others have their turns at the next call.
                    if self.inboxes.is_empty() {
                        break;
                    }
                }
            }
        }
        Passed::Nothing
    }
}
