//! One connection to the bus for all: it distributes received frames to the requests that wait for
//! them.

use std::io::{self, ErrorKind};
use std::ops::RangeInclusive;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, SyncSender};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use canopen::CanFrame;
use host_sim::can::link::{Link, Transmitter};

/// Frames that wait for one request: more than a block of 127 segments.
const FRAMES: usize = 512;

/// What a request waits for.
struct Subscriber {
    identifiers: RangeInclusive<u32>,
    frames: SyncSender<CanFrame>,
}

/// The connection.
#[derive(Default)]
pub struct Hub {
    transmitter: Mutex<Option<Box<dyn Transmitter>>>,
    subscribers: Mutex<Vec<Subscriber>>,
    /// Frames that were sent, for the display.
    sent: Mutex<Vec<CanFrame>>,
}

/// Frames of this program that wait to be displayed.
const SENT: usize = 4096;

/// The content, also after a thread has failed: it is complete between two statements.
pub fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Hub {
    /// The bus is there, or gone.
    pub fn connect(&self, transmitter: Option<Box<dyn Transmitter>>) {
        *lock(&self.transmitter) = transmitter;
    }

    /// Sends a frame.
    ///
    /// # Errors
    /// The bus is disconnected, or the error of the operating system.
    pub fn send(&self, frame: &CanFrame) -> io::Result<()> {
        match lock(&self.transmitter).as_mut() {
            Some(transmitter) => transmitter.send(frame)?,
            None => {
                return Err(io::Error::new(
                    ErrorKind::NotConnected,
                    "the bus is disconnected",
                ));
            }
        }
        let mut sent = lock(&self.sent);
        if sent.len() < SENT {
            sent.push(*frame);
        }
        Ok(())
    }

    /// The frames that were sent since the last call.
    pub fn take_sent(&self) -> Vec<CanFrame> {
        std::mem::take(&mut lock(&self.sent))
    }

    /// Passes a received frame to those who wait for it. A frame that finds no room is lost, as one
    /// that a controller has no room for.
    pub fn deliver(&self, frame: &CanFrame) {
        let (id, is_extended) = frame.raw_id();
        if is_extended {
            return;
        }
        lock(&self.subscribers).retain(|one| {
            !one.identifiers.contains(&id)
                || !matches!(
                    one.frames.try_send(*frame),
                    Err(mpsc::TrySendError::Disconnected(_))
                )
        });
    }

    /// A link that receives frames with these identifiers from now on.
    pub fn link(self: &Arc<Self>, identifiers: RangeInclusive<u32>) -> HubLink {
        let (sender, frames) = mpsc::sync_channel(FRAMES);
        let mut subscribers = lock(&self.subscribers);
        subscribers.push(Subscriber {
            identifiers,
            frames: sender,
        });
        HubLink {
            hub: Arc::clone(self),
            frames,
        }
    }
}

/// The bus for one request.
pub struct HubLink {
    hub: Arc<Hub>,
    frames: Receiver<CanFrame>,
}

impl Link for HubLink {
    fn send(&mut self, frame: &CanFrame) -> io::Result<()> {
        self.hub.send(frame)
    }

    fn receive(&mut self, timeout: Duration) -> io::Result<Option<CanFrame>> {
        match self.frames.recv_timeout(timeout) {
            Ok(frame) => Ok(Some(frame)),
            Err(RecvTimeoutError::Timeout) => Ok(None),
            Err(RecvTimeoutError::Disconnected) => Err(io::Error::new(
                ErrorKind::NotConnected,
                "the bus is disconnected",
            )),
        }
    }
}
