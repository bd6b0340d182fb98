//! A pseudo-terminal, for clients that support only serial devices.

use std::fs::File;
use std::io;
use std::os::unix::ffi::OsStringExt;
use std::path::{Path, PathBuf};

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

/// A link to a terminal, which is removed with this value.
#[derive(Debug)]
pub struct Link(PathBuf);

impl Link {
    /// A link at this path, in place of another link.
    ///
    /// # Errors
    /// The error of the operating system; what is there and not a link stays.
    pub fn new(path: &Path, target: &Path) -> io::Result<Self> {
        if path.is_symlink() {
            std::fs::remove_file(path)?;
        }
        std::os::unix::fs::symlink(target, path)?;
        Ok(Self(path.into()))
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        // Another server may have replaced it, or a user removed it.
        let _ = std::fs::remove_file(&self.0);
    }
}
