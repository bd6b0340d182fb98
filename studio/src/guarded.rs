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

/// The link.
pub struct GuardedLink {
    link: HubLink,
    stops: Arc<AtomicU64>,
    begun: u64,
}

impl GuardedLink {
    /// For work that was requested when there had been this many stops.
    pub fn new(link: HubLink, stops: Arc<AtomicU64>, begun: u64) -> Self {
        Self { link, stops, begun }
    }

    fn check(&self) -> io::Result<()> {
        if self.stops.load(Ordering::SeqCst) == self.begun {
            return Ok(());
        }
        Err(io::Error::new(ErrorKind::ConnectionAborted, "stopped"))
    }
}

impl Link for GuardedLink {
    fn send(&mut self, frame: &CanFrame) -> io::Result<()> {
        self.check()?;
        self.link.send(frame)
    }

    fn receive(&mut self, timeout: Duration) -> io::Result<Option<CanFrame>> {
        let end = Instant::now() + timeout;
        loop {
            self.check()?;
            let left = end.saturating_duration_since(Instant::now());
            let frame = self.link.receive(left.min(SLICE))?;
            if frame.is_some() || left.is_zero() {
                return Ok(frame);
            }
        }
    }

    fn pause(&mut self, time: Duration) -> io::Result<()> {
        std::thread::sleep(time);
        self.check()
    }
}
