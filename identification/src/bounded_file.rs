//! Reads files up to a size: one without end, such as a device, is refused instead of filling the
//! memory.

use std::{
    fs::File,
    io::{self, Read},
    path::Path,
};

/// A file that may have a limited number of bytes. Beyond these, reading fails with
/// [`io::ErrorKind::FileTooLarge`].
#[derive(Debug)]
pub struct BoundedFile {
    file: File,
    read: u64,
    most: u64,
}

impl BoundedFile {
    /// Opens a file of at most this number of bytes.
    ///
    /// # Errors
    /// That of the operating system; [`io::ErrorKind::FileTooLarge`] with size and limit for a file
    /// that is known to be longer.
    pub fn open(path: &Path, most: u64) -> io::Result<Self> {
        let file = File::open(path)?;
        // A device and a pipe have a length of zero.
        let length = file.metadata()?.len();
        if length > most {
            return Err(too_large(format!("it has {length} bytes"), most));
        }
        Ok(Self {
            file,
            read: 0,
            most,
        })
    }
}

impl Read for BoundedFile {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let count = self.file.read(bytes)?;
        self.read += count as u64;
        if self.read > self.most {
            let found = format!("it continues after {} bytes", self.most);
            return Err(too_large(found, self.most));
        }
        Ok(count)
    }
}

fn too_large(found: String, most: u64) -> io::Error {
    let problem = format!("{found}, expected at most {most}");
    io::Error::new(io::ErrorKind::FileTooLarge, problem)
}

/// Reads a file of at most this number of bytes.
///
/// # Errors
/// Those of [`BoundedFile`].
pub fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    BoundedFile::open(path, most)?.read_to_end(&mut bytes)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_read_up_to_its_limit_and_a_longer_one_is_refused_with_its_size() {
        let file = tempfile::NamedTempFile::new().expect("a file");
        std::fs::write(file.path(), "12345").expect("its content");
        assert_eq!(read(file.path(), 5).expect("short enough"), b"12345");
        let error = read(file.path(), 4).expect_err("too long");
        assert_eq!(error.kind(), io::ErrorKind::FileTooLarge);
        assert_eq!(error.to_string(), "it has 5 bytes, expected at most 4");
    }

    #[cfg(unix)]
    #[test]
    fn a_device_without_end_is_refused() {
        let error = read(Path::new("/dev/zero"), 100_000).expect_err("it has no end");
        assert_eq!(
            error.to_string(),
            "it continues after 100000 bytes, expected at most 100000"
        );
    }
}
