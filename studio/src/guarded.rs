//! A link for work that moves a shaft: after a stop it sends nothing more, so that what was under
//! way cannot undo the stop.

use std::io::{self, ErrorKind};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use canopen::CanFrame;
use host_sim::can::link::Link;

use crate::bus::HubLink;

/// Time after which a stop is detected while the work waits.
const SLICE: Duration = Duration::from_millis(10);

/// The stops of a node since its work was requested.
#[derive(Debug, Clone)]
pub struct Guard {
    stops: Arc<AtomicU64>,
    begun: u64,
}

impl Guard {
    /// For work that is requested now; `stops` counts those of the node.
    pub fn new(stops: Arc<AtomicU64>) -> Self {
        let begun = stops.load(Ordering::SeqCst);
        Self { stops, begun }
    }

    /// Whether there has been a stop.
    pub fn is_stopped(&self) -> bool {
        self.stops.load(Ordering::SeqCst) != self.begun
    }

    fn check(&self) -> io::Result<()> {
        if self.is_stopped() {
            return Err(io::Error::new(ErrorKind::ConnectionAborted, "stopped"));
        }
        Ok(())
    }
}

/// The link.
pub struct GuardedLink {
    link: HubLink,
    guard: Guard,
}

impl GuardedLink {
    /// For the work of this guard.
    pub fn new(link: HubLink, guard: Guard) -> Self {
        Self { link, guard }
    }
}

impl Link for GuardedLink {
    fn send(&mut self, frame: &CanFrame) -> io::Result<()> {
        self.guard.check()?;
        self.link.send(frame)
    }

    fn receive(&mut self, timeout: Duration) -> io::Result<Option<CanFrame>> {
        let end = Instant::now() + timeout;
        loop {
            self.guard.check()?;
            let left = end.saturating_duration_since(Instant::now());
            let frame = self.link.receive(left.min(SLICE))?;
            if frame.is_some() || left.is_zero() {
                return Ok(frame);
            }
        }
    }

    fn pause(&mut self, time: Duration) -> io::Result<()> {
        std::thread::sleep(time);
        self.guard.check()
    }
}
