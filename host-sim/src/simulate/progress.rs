//! Progress of runs, and their end before time.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use crate::error::Error;

/// Ticks between two checks: 4 s, a whole number of periods of PWM and control. The slowest plant
/// takes some 30 ms for them.
pub(super) const CHECK_TICKS: u64 = 80_000;

/// The progress of one or more runs, for another thread that shows it or ends them.
///
/// ```
/// use host_sim::{scenario::Scenario, settings::ModelKind, simulate::RunProgress};
///
/// let scenario = Scenario { model: Some(ModelKind::GreyBox), ..Scenario::default() };
/// let mut simulation = scenario.resolve().unwrap();
/// let progress = std::sync::Arc::new(RunProgress::default());
/// simulation.progress = Some(progress.clone());
/// simulation.record().unwrap();
/// assert_eq!(progress.ticks(), simulation.ticks);
/// progress.stop();
/// assert!(simulation.record().is_err());
/// ```
#[derive(Debug, Default)]
pub struct RunProgress {
    ticks: AtomicU64,
    is_stopped: AtomicBool,
}

impl RunProgress {
    /// Ticks of 50 us that have been simulated, of all runs together.
    pub fn ticks(&self) -> u64 {
        self.ticks.load(Ordering::Relaxed)
    }

    /// Ends the runs: each returns [`Error::Interrupted`].
    pub fn stop(&self) {
        self.is_stopped.store(true, Ordering::Relaxed);
    }

    /// Counts ticks.
    ///
    /// # Errors
    /// [`Error::Interrupted`] after [`RunProgress::stop`].
    pub fn advance(&self, ticks: u64) -> Result<(), Error> {
        self.ticks.fetch_add(ticks, Ordering::Relaxed);
        match self.is_stopped.load(Ordering::Relaxed) {
            true => Err(Error::Interrupted),
            false => Ok(()),
        }
    }
}
