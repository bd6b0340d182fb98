//! Interrupts (Ctrl-C) and requests to end the program.
//!
//! A command that takes time removes its unfinished files and ends; one that runs until it is
//! stopped takes a flag instead, and ends when it is set.

use std::sync::{
    Arc, OnceLock,
    atomic::{AtomicBool, Ordering},
};

use host_sim::file;

use crate::error::Error;

/// Exit status after an interrupt, as shells report it.
const INTERRUPTED: i32 = 130;

/// The flag of a command that checks it.
static STOP: OnceLock<Arc<AtomicBool>> = OnceLock::new();

/// Whether the handler is installed.
static INSTALLED: AtomicBool = AtomicBool::new(false);

/// Handles interrupts from now on, unless the program was started with signals ignored: `nohup`
/// and the jobs of a script remain as they are.
pub fn handle() {
    INSTALLED.store(
        ctrlc::try_set_handler(interrupted).is_ok(),
        Ordering::Relaxed,
    );
}

fn interrupted() {
    if let Some(stop) = STOP.get()
        && !stop.swap(true, Ordering::Relaxed)
    {
        return;
    }
    file::abandon();
    std::process::exit(INTERRUPTED);
}

/// A flag that the first interrupt sets; the second one ends the program.
pub fn stop() -> Result<Arc<AtomicBool>, Error> {
    let stop = STOP.get_or_init(Arc::default);
    if !INSTALLED.load(Ordering::Relaxed) {
        ctrlc::set_handler(interrupted)
            .map_err(|error| Error::Conflict(format!("cannot handle interrupts: {error}")))?;
        INSTALLED.store(true, Ordering::Relaxed);
    }
    Ok(Arc::clone(stop))
}
