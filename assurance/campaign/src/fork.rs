//! Copies of this process. Each of them owns the emulated board as it is at the instant of the
//! copy, and carries out one experiment on it.

use std::collections::HashMap;
use std::io::{self, PipeReader, PipeWriter, Read, Write};
use std::os::fd::AsFd;

use nix::errno::Errno;
use nix::libc;
use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
use nix::sys::wait::waitpid;
use nix::unistd::{ForkResult, Pid, alarm, fork};

/// Time after which a copy is ended, s: an experiment takes less than a second of an idle
/// processor, and a program that restarts all the time some ten.
const LIMIT_S: u32 = 300;

/// The end of a copy's pipe, for what it has found.
#[derive(Debug)]
pub struct Reporter(PipeWriter);

impl Reporter {
    /// Sends what the copy has found, and ends it.
    pub fn end(mut self, found: &[u8]) -> ! {
        // The report of a copy is not read once its original has ended.
        let _ = self.0.write_all(found);
        exit()
    }
}

/// Ends this process without the destructors and buffers of the original.
#[allow(
    unsafe_code,
    reason = "the standard library has no exit without destructors"
)]
fn exit() -> ! {
    // SAFETY: `_exit` has no precondition.
    unsafe { libc::_exit(0) }
}

/// The running copies, each with what it works on.
#[derive(Debug)]
pub struct Copies<T> {
    running: HashMap<Pid, (T, PipeReader)>,
}

impl<T> Default for Copies<T> {
    fn default() -> Self {
        Self {
            running: HashMap::new(),
        }
    }
}

impl<T> Copies<T> {
    /// Number of running copies.
    pub fn len(&self) -> usize {
        self.running.len()
    }

    /// Whether no copy is running.
    pub fn is_empty(&self) -> bool {
        self.running.is_empty()
    }

    /// Copies this process. Returns the reporter in the copy, and `None` in the original.
    ///
    /// # Errors
    /// The operating system has no memory, process or file left.
    pub fn start(&mut self, work: T) -> io::Result<Option<Reporter>> {
        let (reader, writer) = io::pipe()?;
        match copy_process()? {
            ForkResult::Child => {
                // Its default action ends the process.
                alarm::set(LIMIT_S);
                Ok(Some(Reporter(writer)))
            }
            ForkResult::Parent { child } => {
                self.running.insert(child, (work, reader));
                Ok(None)
            }
        }
    }

    /// Waits until a copy has ended. Returns its work and what it has found, which is empty if it
    /// ended without a report; `None` if no copy is running.
    ///
    /// # Errors
    /// The operating system does not know a copy, or its pipe cannot be read.
    pub fn wait(&mut self) -> io::Result<Option<(T, Vec<u8>)>> {
        let Some(pid) = self.first_readable()? else {
            return Ok(None);
        };
        let Some((work, mut reader)) = self.running.remove(&pid) else {
            return Ok(None);
        };
        // A copy may report more than its pipe holds, and then ends only when all is read.
        let mut found = Vec::new();
        reader.read_to_end(&mut found)?;
        waitpid(pid, None)?;
        Ok(Some((work, found)))
    }

    /// Waits until a copy reports or ends; `None` if no copy is running.
    fn first_readable(&self) -> io::Result<Option<Pid>> {
        if self.running.is_empty() {
            return Ok(None);
        }
        let (pids, mut files): (Vec<Pid>, Vec<PollFd<'_>>) = (self.running.iter())
            .map(|(pid, (_, reader))| (*pid, PollFd::new(reader.as_fd(), PollFlags::POLLIN)))
            .unzip();
        while let Err(error) = poll(&mut files, PollTimeout::NONE) {
            if error != Errno::EINTR {
                return Err(error.into());
            }
        }
        let ready = files.iter().position(|file| file.any() == Some(true));
        Ok(ready.map(|at| pids[at]))
    }
}

#[allow(
    unsafe_code,
    reason = "a copy of the emulated board is a copy of the process"
)]
fn copy_process() -> io::Result<ForkResult> {
    // SAFETY: the copy has this thread alone. A campaign's other threads wait for this one in
    // `join` meanwhile, hold no lock that it needs, and the allocator of the C library is usable
    // after a copy. The copy ends by `exit` or by its alarm.
    let result = unsafe { fork() };
    result.map_err(io::Error::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_copy_reports_to_its_original_and_one_that_ends_early_reports_nothing() {
        let mut copies = Copies::default();
        let mut value = 1_u8;
        for work in ["reports", "ends"] {
            if let Some(reporter) = copies.start(work).unwrap() {
                value += 1;
                match work {
                    "reports" => reporter.end(&[value]),
                    _ => exit(),
                }
            }
        }
        let mut found = [copies.wait(), copies.wait()].map(|ended| ended.unwrap().unwrap());
        found.sort_unstable();
        assert_eq!(found, [("ends", vec![]), ("reports", vec![2])]);
        assert!(copies.is_empty() && copies.wait().unwrap().is_none());
        assert_eq!(value, 1);
    }
}
