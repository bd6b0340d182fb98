//! Files that are there as a whole or not at all.

use std::{fs, io, path::Path};

use crate::error::Error;

/// Writes a text file: beside its place first, then moved there, so that no half of it is ever
/// found under its name and an old one stays until the new one is complete.
///
/// # Errors
/// [`Error::Write`].
pub fn write(path: &Path, text: &str) -> Result<(), Error> {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".part");
    let part = path.with_file_name(name);
    let result = fs::write(&part, text).and_then(|()| fs::rename(&part, path));
    result.map_err(|source| {
        // Whatever hindered it hinders this too, or not: there is nothing else to be done.
        let _: io::Result<()> = fs::remove_file(&part);
        Error::Write {
            path: path.into(),
            source,
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_and_nothing_else_remains() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("report.html");
        write(&path, "old").expect("a first one");
        write(&path, "new").expect("a second one");
        assert_eq!(fs::read_to_string(&path).expect("the file"), "new");
        assert_eq!(fs::read_dir(folder.path()).expect("the folder").count(), 1);
    }

    #[test]
    fn what_cannot_be_written_is_named_and_leaves_nothing_behind() {
        let folder = tempfile::tempdir().expect("a folder");
        let taken = folder.path().join("taken");
        fs::create_dir(&taken).expect("a folder in the way");
        let error = write(&taken, "text").expect_err("no file").to_string();
        assert!(error.contains("taken"), "{error}");
        assert_eq!(fs::read_dir(folder.path()).expect("the folder").count(), 1);
    }
}
