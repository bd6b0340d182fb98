//! A bus of servos in place of a CAN bus.
//!
//! One thread owns the port, as packets are requests with answers: it ends motions, carries out the
//! requests of pages, samples all servos, and probes those that are missing, in this order. Nothing
//! of it takes longer than a few answers, so that a stop waits for no scan.

mod bus;
mod changes;
mod servo;

use std::sync::atomic::{AtomicU8, Ordering::Relaxed};
use std::sync::mpsc::{self, Receiver, SyncSender};

use host_sim::servo_bus::client::{Client, IDS};

use crate::core::Busy;

pub use bus::run;
pub use changes::attach;
pub use servo::{Servo, WATCHDOG};

/// Jobs that wait for the line.
const JOBS: usize = 64;

/// Longest time between two samples of a servo that is plotted as a line, s: six Dynamixels at
/// 57,600 bit/s are sampled every 60 ms.
pub const GAP_S: f64 = 0.15;

/// Work with the line; the reason where there is none.
pub type Job = Box<dyn FnOnce(Result<&mut Client, String>) + Send>;

/// Requests to the thread of the bus.
pub struct Servos {
    jobs: SyncSender<Job>,
    /// The ID that the scan probes next; behind the last one without a scan.
    next_id: AtomicU8,
}

impl Servos {
    /// The sender of requests, and the receiver for the thread, which begins with a scan.
    pub fn new() -> (Self, Receiver<Job>) {
        let (jobs, receiver) = mpsc::sync_channel(JOBS);
        let next_id = AtomicU8::new(*IDS.start());
        (Self { jobs, next_id }, receiver)
    }

    /// Requests work.
    ///
    /// # Errors
    /// [`Busy`].
    pub fn request(
        &self,
        job: impl FnOnce(Result<&mut Client, String>) + Send + 'static,
    ) -> Result<(), Busy> {
        self.jobs.try_send(Box::new(job)).map_err(|_| Busy)
    }

    /// Begins a scan, or begins it anew.
    pub fn scan(&self) {
        self.next_id.store(*IDS.start(), Relaxed);
    }

    /// Ends the scan.
    pub fn end_scan(&self) {
        self.next_id.store(IDS.end() + 1, Relaxed);
    }

    /// The ID that is to be probed.
    fn next_probe(&self) -> Option<u8> {
        Some(self.next_id.load(Relaxed)).filter(|id| IDS.contains(id))
    }

    /// This ID has been probed, unless the scan has begun anew or ended meanwhile.
    fn has_probed(&self, id: u8) {
        let _ = (self.next_id).compare_exchange(id, id + 1, Relaxed, Relaxed);
    }
}
