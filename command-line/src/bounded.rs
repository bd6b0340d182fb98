//! Files that options name, read up to a limit.

use std::path::Path;

use host_sim::error::Error as SimulatorError;
use identification::bounded_file;

use crate::error::Error;

/// The most bytes of an ELF file or a shared library: a hundred times those of the actuator board's
/// program with all its debug information.
pub const MOST_BUILD: u64 = 1 << 28;

/// Reads a file of at most this number of bytes.
///
/// # Errors
/// For a file that cannot be read or is longer.
pub fn read(path: &Path, most: u64) -> Result<Vec<u8>, Error> {
    bounded_file::read(path, most).map_err(|source| {
        let path = path.into();
        SimulatorError::Read { path, source }.into()
    })
}
