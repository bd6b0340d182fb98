//! The release notes: what has changed, and the checksums of what is flashed.

use std::{fs, path::Path};

use sha2::{Digest, Sha256};

use crate::error::{Error, at};

const NAME: &str = "RELEASE-NOTES.md";

/// Types of the files that have the same bytes for everyone who builds the same source with the same
/// key; ELF files name folders.
const REPRODUCIBLE: [&str; 2] = ["bin", "img"];

/// Writes the notes of this version from the list of all changes, with the checksums of the boards'
/// programs in the folder of the release.
pub fn write(changes: &str, out: &Path) -> Result<(), Error> {
    let mut text = format!("# {}\n", section(changes, env!("CARGO_PKG_VERSION")));
    let sums = sums(&out.join("boards"))?;
    if !sums.is_empty() {
        text += &format!(
            "\n## SHA-256 of the boards' programs\n\nThe same source and key give the same bytes.\n\n\
             | file | SHA-256 |\n|---|---|\n{sums}"
        );
    }
    let place = out.join(NAME);
    fs::write(&place, text).map_err(at(&place))
}

/// The section of a version in a list of changes, without the marks of its heading.
fn section<'a>(changes: &'a str, version: &'a str) -> &'a str {
    let mut sections = changes.split("\n## ").skip(1);
    let of_version = sections.find(|text| text.split_whitespace().next() == Some(version));
    of_version.map_or(version, str::trim_end)
}

/// Rows of a table with the names and checksums of the files in a folder, which may be missing.
fn sums(folder: &Path) -> Result<String, Error> {
    let Ok(entries) = fs::read_dir(folder) else {
        return Ok(String::new());
    };
    let mut rows = Vec::new();
    for entry in entries {
        let path = entry.map_err(at(folder))?.path();
        let kind = path.extension().unwrap_or_default();
        if REPRODUCIBLE.iter().any(|other| kind == *other) {
            let bytes = fs::read(&path).map_err(at(&path))?;
            let name = path.strip_prefix(folder).unwrap_or(&path).display();
            rows.push(format!("| `{name}` | `{:x}` |\n", Sha256::digest(&bytes)));
        }
    }
    rows.sort();
    Ok(rows.concat())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_notes_are_the_changes_of_this_version_and_the_sums_of_what_is_flashed() {
        let folder = tempfile::tempdir().expect("a folder");
        let version = env!("CARGO_PKG_VERSION");
        let changes = format!(
            "# Changes\n\n## 99.0.0\n\nLater.\n\n## {version}\n\nThis.\n\n## 0.0.1\n\nOld.\n"
        );
        let notes = || {
            write(&changes, folder.path()).expect("the notes");
            fs::read_to_string(folder.path().join(NAME)).expect("the file")
        };
        assert_eq!(notes(), format!("# {version}\n\nThis.\n"));
        let boards = folder.path().join("boards");
        fs::create_dir(&boards).expect("a folder in it");
        for name in ["b.img", "a.bin", "a.elf"] {
            fs::write(boards.join(name), "abc").expect("a file");
        }
        // FIPS 180-2, appendix B.1.
        let sum = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert!(notes().ends_with(&format!(
            "|---|---|\n| `a.bin` | `{sum}` |\n| `b.img` | `{sum}` |\n"
        )));
    }
}
