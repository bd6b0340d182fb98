//! The checksums of all files, in the format of `sha256sum --check`.

use std::{
    fs,
    path::{Path, PathBuf},
};

use sha2::{Digest, Sha256};

use crate::error::{Error, at};

const NAME: &str = "SHA256SUMS";

/// Writes the checksums of all files below a folder.
pub fn write(folder: &Path) -> Result<(), Error> {
    let mut text = String::new();
    for path in files(folder)? {
        let name = path.strip_prefix(folder).unwrap_or(&path);
        text += &format!("{}  {}\n", sum(&path)?, name.display());
    }
    let place = folder.join(NAME);
    fs::write(&place, text).map_err(at(&place))
}

/// All files below a folder but that of the checksums, in the order of their names.
pub fn files(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let mut files = Vec::new();
    collect(folder, &mut files)?;
    files.sort();
    Ok(files)
}

/// The checksum of a file in hexadecimal digits.
pub fn sum(path: &Path) -> Result<String, Error> {
    let bytes = fs::read(path).map_err(at(path))?;
    Ok(format!("{:x}", Sha256::digest(&bytes)))
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) -> Result<(), Error> {
    for entry in fs::read_dir(folder).map_err(at(folder))? {
        let path = entry.map_err(at(folder))?.path();
        if path.is_dir() && !path.is_symlink() {
            collect(&path, files)?;
        } else if path.file_name().is_none_or(|name| name != NAME) {
            files.push(path);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sums_are_those_of_the_standard_in_the_order_of_the_names() {
        let folder = tempfile::tempdir().expect("a folder");
        fs::create_dir(folder.path().join("b")).expect("a folder in it");
        fs::write(folder.path().join("b/abc"), "abc").expect("a file");
        fs::write(folder.path().join("a"), "").expect("a file");
        for _ in 0..2 {
            write(folder.path()).expect("the sums");
        }
        // FIPS 180-2, appendix B.1, and the empty message.
        let expected = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855  a\n\
                        ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad  b/abc\n";
        let text = fs::read_to_string(folder.path().join(NAME)).expect("the file");
        assert_eq!(text, expected);
    }
}
