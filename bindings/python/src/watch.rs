//! Long computations in a thread of their own, so that the interpreter can interrupt them and show
//! their progress.

use std::{
    sync::mpsc::{self, RecvTimeoutError},
    thread,
    time::Duration,
};

use pyo3::{exceptions::PyRuntimeError, prelude::*};

/// Time between two checks for an interrupt, and between two reports of progress.
const CHECK_PERIOD: Duration = Duration::from_millis(50);

/// A progress callback of the caller: `report(done, total)`.
pub type Report<'py> = Option<Bound<'py, PyAny>>;

/// Runs a job in another thread, without the interpreter lock.
///
/// `progress` returns the finished part and the total, for the callback. An interrupt, or an
/// exception of the callback, calls `stop` and returns at once: the thread ends at its next check.
pub fn run<T: Send + 'static>(
    py: Python<'_>,
    report: &Report<'_>,
    progress: impl Fn() -> (f64, f64),
    stop: impl Fn(),
    job: impl FnOnce() -> T + Send + 'static,
) -> PyResult<T> {
    let (send, mut receive) = mpsc::sync_channel(1);
    // Without a receiver the result is not needed any more.
    let job = move || drop(send.send(job()));
    let started = thread::Builder::new().spawn(job);
    started.map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
    let send_progress = || match report {
        Some(report) => report.call1(progress()).map(drop),
        None => Ok(()),
    };
    loop {
        let received;
        // A receiver can be moved, but not shared, with code that runs without the lock.
        (receive, received) = py.detach(move || {
            let received = receive.recv_timeout(CHECK_PERIOD);
            (receive, received)
        });
        match received {
            Ok(result) => {
                send_progress()?;
                return Ok(result);
            }
            Err(RecvTimeoutError::Disconnected) => {
                return Err(PyRuntimeError::new_err(
                    "the computation ended unexpectedly",
                ));
            }
            Err(RecvTimeoutError::Timeout) => {}
        }
        if let Err(interruption) = py.check_signals().and_then(|()| send_progress()) {
            stop();
            return Err(interruption);
        }
    }
}
