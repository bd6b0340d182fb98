//! A pseudo-terminal, for clients that support only serial devices.

use std::fs::File;
use std::io;
use std::os::unix::ffi::OsStringExt;
use std::path::PathBuf;

use rustix::fs::{OFlags, fcntl_setfl};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

/// Our side of a terminal that never waits, and the path of the other one.
///
/// # Errors
/// The error of the operating system.
pub fn open() -> io::Result<(File, PathBuf)> {
    let terminal = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)?;
    grantpt(&terminal)?;
    unlockpt(&terminal)?;
    let path = ptsname(&terminal, Vec::new())?;
    // Bytes as they are: no echo, no lines.
    let mut settings = tcgetattr(&terminal)?;
    settings.make_raw();
    tcsetattr(&terminal, OptionalActions::Now, &settings)?;
    fcntl_setfl(&terminal, OFlags::RDWR | OFlags::NONBLOCK)?;
    let path = PathBuf::from(std::ffi::OsString::from_vec(path.into_bytes()));
    Ok((File::from(terminal), path))
}
